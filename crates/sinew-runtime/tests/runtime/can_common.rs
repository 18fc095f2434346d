//! Simulated nodes on CAN that fail when a test says so.

use crate::common::{Setup, bare_machine};
use sinew::control::arm::ArmStatus;
use sinew_runtime::can::{
    CanBus, CanDevice, CanFault, CanNode, Frame, Link, Protocol, Sign, SimulatedLink, SimulatedMachine,
};
use sinew_segment::CanDrive;
use sinew_session::Exchange;
use std::cell::RefCell;
use std::io;
use std::rc::Rc;

/// A cycle in the middle of the motion.
pub(crate) const MIDDLE: u64 = 1000;
/// What a moteus shows that heard nothing for the time of its watchdog.
pub(crate) const TIMED_OUT: u32 = 11;

/// What happens, to the node of this index where there is one.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Act {
    Fault(usize, CanFault),
    Restart(usize),
    Raise(usize, u32),
    Cut,
    Unplug,
    /// The program stands for so many periods.
    Stall(u64),
}

/// The watchdog that a link has beside the program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Guard {
    Real,
    /// There is none.
    Missing,
    /// It does nothing.
    Idle,
}

/// A link that is there after its bus is gone, what is done before a cycle, and what has been.
#[derive(Clone)]
pub(crate) struct Watched(pub(crate) Rc<RefCell<Inner>>);

pub(crate) struct Inner {
    pub(crate) link: SimulatedLink,
    pub(crate) acts: Vec<(u64, Act)>,
    pub(crate) cycle: u64,
    pub(crate) unplugged: bool,
    /// Every frame that comes is changed by this.
    pub(crate) damage: Option<fn(&Frame) -> Frame>,
    /// Whether it has frames of CAN FD.
    pub(crate) fd: bool,
    pub(crate) guard: Guard,
}

impl Watched {
    pub(crate) fn new(setup: &Setup, nodes: &[CanDevice]) -> Self {
        let machine = SimulatedMachine::new(setup.plant.clone(), &setup.machine, nodes, true);
        let link = SimulatedLink::new(machine);
        Self(Rc::new(RefCell::new(Inner {
            link,
            acts: Vec::new(),
            cycle: 0,
            unplugged: false,
            damage: None,
            fd: true,
            guard: Guard::Real,
        })))
    }

    pub(crate) fn with(self, cycle: u64, act: Act) -> Self {
        self.0.borrow_mut().acts.push((cycle, act));
        self
    }

    /// True tensions of the cables at their drives, N.
    pub(crate) fn tensions(&self) -> Vec<f64> {
        let inner = self.0.borrow();
        let machine = inner.link.simulated().unwrap();
        machine.arm().truth().cables.iter().map(|cable| cable.tension_in).collect()
    }

    /// Cycles of the start are none of the run.
    pub(crate) fn begin(&self) {
        self.0.borrow_mut().cycle = 0;
    }

    /// Whether a node has power; one that is not on CANopen, which has no brake, may stand with it.
    pub(crate) fn moves(&self, k: usize) -> bool {
        let mut inner = self.0.borrow_mut();
        let node = inner.link.machine_mut().nodes_mut().nth(k).unwrap();
        match node.drive_mut() {
            CanDrive::Canopen(drive) => drive.brake_released(),
            CanDrive::Cansimple(axis) => axis.command().is_some_and(|velocity| velocity != 0.0),
            // A position that is held is not reached to the last bit.
            CanDrive::Moteus(node) => node.command().is_some_and(|velocity| velocity.abs() > 1e-3),
            // There is no 0 in its bits.
            CanDrive::Mit(motor) => {
                let velocity = motor.command().velocity;
                motor.torque(0.0, 0.0).is_some() && velocity.abs() > 0.02
            }
        }
    }

    pub(crate) fn nodes<T>(&self, see: impl Fn(&CanNode) -> T) -> Vec<T> {
        self.0.borrow_mut().link.machine_mut().nodes().map(see).collect()
    }
}

impl Link for Watched {
    fn carries_fd(&self) -> bool {
        self.0.borrow().fd
    }
    fn now(&mut self) -> u64 {
        self.0.borrow_mut().link.now()
    }
    fn send(&mut self, frames: &[Frame]) -> io::Result<()> {
        let mut inner = self.0.borrow_mut();
        if inner.unplugged { Err(io::ErrorKind::UnexpectedEof.into()) } else { inner.link.send(frames) }
    }
    fn receive(&mut self, deadline: u64) -> io::Result<Option<Frame>> {
        let mut inner = self.0.borrow_mut();
        if inner.unplugged {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        let frame = inner.link.receive(deadline)?;
        Ok(frame.map(|frame| inner.damage.map_or(frame, |damage| damage(&frame))))
    }
    fn rest_until(&mut self, time: u64) {
        self.0.borrow_mut().link.rest_until(time);
    }
    fn begin_cycle(&mut self, period: u64) {
        let Inner { link, acts, cycle, unplugged, .. } = &mut *self.0.borrow_mut();
        for (_, act) in acts.iter().filter(|(at, _)| at == cycle) {
            let mut nodes = link.machine_mut().nodes_mut();
            match *act {
                Act::Fault(k, fault) => nodes.nth(k).unwrap().set_fault(Some(fault)),
                Act::Restart(k) => nodes.nth(k).unwrap().restart(),
                Act::Raise(k, code) => nodes.nth(k).unwrap().raise_fault(code),
                Act::Cut => {
                    drop(nodes);
                    link.cut();
                }
                Act::Unplug => *unplugged = true,
                Act::Stall(periods) => {
                    drop(nodes);
                    (0..periods).for_each(|_| link.begin_cycle(period));
                }
            }
        }
        *cycle += 1;
        link.begin_cycle(period);
    }
    fn guard(&mut self, leave: &[Frame], time: u64) -> io::Result<()> {
        let mut inner = self.0.borrow_mut();
        match inner.guard {
            Guard::Real => inner.link.guard(leave, time),
            Guard::Missing => Err(io::ErrorKind::NotFound.into()),
            Guard::Idle => Ok(()),
        }
    }
    fn sign(&mut self, sign: Sign) -> io::Result<()> {
        self.0.borrow_mut().link.sign(sign)
    }
}

pub(crate) fn setup_on(name: &str, protocol: Protocol) -> (Setup, Vec<CanDevice>) {
    let (setup, nodes) = setup(name);
    let nodes = nodes.into_iter().map(|node| node.on(protocol, &setup.machine)).collect();
    (setup, nodes)
}

pub(crate) fn setup(name: &str) -> (Setup, Vec<CanDevice>) {
    // The motion begins when the cables have their tensions.
    let setup = Setup { before: 3.0, ..Setup::new(bare_machine(name), 3, &[]) };
    let nodes = CanDevice::simulated(&setup.machine);
    (setup, nodes)
}

pub(crate) fn bus(setup: &Setup, nodes: &[CanDevice]) -> CanBus<SimulatedLink> {
    let machine = SimulatedMachine::new(setup.plant.clone(), &setup.machine, nodes, true);
    CanBus::start(SimulatedLink::new(machine), &setup.machine, nodes).unwrap()
}

/// The cycle in which a machine is stopped, the fault of the bus in it, and the fault as its supervisor names
/// it; none for a run to its end.
pub(crate) fn stopped(
    setup: &Setup,
    watched: &Watched,
    nodes: &[CanDevice],
) -> Option<(u64, Exchange, String)> {
    let bus = CanBus::start(watched.clone(), &setup.machine, nodes).unwrap();
    watched.begin();
    let (mut found, mut cycles, mut moving) = (None, 0, 0);
    setup.run(bus, |record| {
        cycles += 1;
        if let (None, ArmStatus::Stopped(fault)) = (&found, record.command.arm.status) {
            found = Some((cycles, record.exchange, format!("{fault:?}")));
        }
        if found.as_ref().is_some_and(|(at, ..)| cycles > at + 400) {
            moving += usize::from(watched.moves(1));
        }
    });
    if found.is_some() {
        assert_eq!(moving, 0, "the second drive does not move again by itself");
    }
    // What hears no heartbeat is stopped by its own watchdog; a moteus then holds still, with power.
    let left = watched.nodes(|node| node.has_power() && node.error() != TIMED_OUT);
    assert!(left.iter().all(|powered| !powered), "no power at the end");
    found
}
