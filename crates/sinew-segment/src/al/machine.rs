//! Requests of the master, what speaks against them, and what the device does by itself.
//!
//! Source: ETG.1000.6, 6.4.1 and table 103 to 105 (state machine), table 9 to 11 (AL control, status, codes).

use super::{AlState, AlStatusCode};

/// Bits of AL control and status.
const STATE: u16 = 0x0f;
const ERROR: u16 = 0x10;
const IDENTIFICATION: u16 = 0x20;
const BOOT: u8 = 3;
/// How long a device in SAFE-OP waits for outputs after OP was requested, ns.
const OUTPUTS_WAIT_NS: u64 = 1_000_000_000;

/// What the machine asks the rest of the device.
pub(crate) trait Surroundings {
    /// Why a transition one step up is not possible.
    fn obstacle(&mut self, to: AlState) -> Option<AlStatusCode>;
    /// Outputs have come since SAFE-OP, or there are none to wait for.
    fn has_outputs(&self) -> bool;
    /// The state changes: what has to be prepared or stopped.
    fn enter(&mut self, from: AlState, to: AlState);
}

/// A change of the status that the master sees.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Transition {
    pub(crate) status: u16,
    pub(crate) code: u16,
}

/// The state machine of one device.
#[derive(Debug, Clone)]
pub(crate) struct Machine {
    state: AlState,
    code: AlStatusCode,
    pending: Option<Pending>,
    transition_ns: u64,
    identification: Option<u16>,
    showing_identification: bool,
}

#[derive(Debug, Clone, Copy)]
struct Pending {
    request: u16,
    due: u64,
    waiting_since: Option<u64>,
}

impl Machine {
    pub(crate) fn new(transition_ns: u64, identification: Option<u16>) -> Self {
        Self {
            state: AlState::Init,
            code: AlStatusCode::NoError,
            pending: None,
            transition_ns,
            identification,
            showing_identification: false,
        }
    }

    pub(crate) fn state(&self) -> AlState {
        self.state
    }

    pub(crate) fn code(&self) -> AlStatusCode {
        self.code
    }

    /// A request is still worked on.
    pub(crate) fn is_busy(&self) -> bool {
        self.pending.is_some()
    }

    /// AL control was written. A newer request replaces one that is still worked on.
    pub(crate) fn request(&mut self, control: u16, now: u64) {
        self.pending = Some(Pending { request: control, due: now + self.transition_ns, waiting_since: None });
    }

    /// Works on a request that is due. Some where the status changes.
    pub(crate) fn advance(&mut self, now: u64, surroundings: &mut impl Surroundings) -> Option<Transition> {
        let mut pending = self.pending.filter(|pending| now >= pending.due)?;
        let desired = (pending.request & STATE) as u8;
        self.showing_identification = pending.request & IDENTIFICATION != 0;
        let acknowledged = pending.request & ERROR != 0;
        if self.code != AlStatusCode::NoError && !acknowledged && desired != AlState::Init.number() {
            // An error stands until it is acknowledged; only the way down is open.
            if AlState::from_number(desired).is_none_or(|desired| desired >= self.state) {
                self.pending = None;
                return Some(self.shown());
            }
        }
        let Some(target) = AlState::from_number(desired) else {
            let code = if desired == BOOT { AlStatusCode::NoBootstrap } else { AlStatusCode::UnknownState };
            return Some(self.refuse(code));
        };
        if acknowledged || target < self.state {
            self.code = AlStatusCode::NoError;
        }
        if target > self.state {
            if step_up(self.state) != Some(target) {
                return Some(self.refuse(AlStatusCode::InvalidStateChange));
            }
            if let Some(code) = surroundings.obstacle(target) {
                return Some(self.refuse(code));
            }
            if target == AlState::Op && !surroundings.has_outputs() {
                let since = *pending.waiting_since.get_or_insert(now);
                self.pending = Some(pending);
                return (now - since >= OUTPUTS_WAIT_NS).then(|| self.refuse(AlStatusCode::NoValidOutputs));
            }
        }
        self.pending = None;
        self.change(target, surroundings);
        Some(self.shown())
    }

    /// The device leaves its state by itself, with an error.
    pub(crate) fn fall(
        &mut self,
        to: AlState,
        code: AlStatusCode,
        surroundings: &mut impl Surroundings,
    ) -> Transition {
        self.pending = None;
        self.code = code;
        if to < self.state {
            self.change(to, surroundings);
        }
        self.shown()
    }

    fn change(&mut self, target: AlState, surroundings: &mut impl Surroundings) {
        let from = self.state;
        self.state = target;
        if from != target {
            surroundings.enter(from, target);
        }
    }

    fn refuse(&mut self, code: AlStatusCode) -> Transition {
        self.pending = None;
        self.code = code;
        self.shown()
    }

    /// Status and code as in the registers. An identification takes the place of the code, with bit 5 set.
    fn shown(&self) -> Transition {
        let state = u16::from(self.state.number());
        if self.code != AlStatusCode::NoError {
            return Transition { status: state | ERROR, code: self.code.number() };
        }
        match self.identification.filter(|_| self.showing_identification) {
            Some(identification) => Transition { status: state | IDENTIFICATION, code: identification },
            None => Transition { status: state, code: 0 },
        }
    }
}

fn step_up(from: AlState) -> Option<AlState> {
    match from {
        AlState::Init => Some(AlState::PreOp),
        AlState::PreOp => Some(AlState::SafeOp),
        AlState::SafeOp => Some(AlState::Op),
        AlState::Op => None,
    }
}
