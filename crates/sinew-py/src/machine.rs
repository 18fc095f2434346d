//! Machines: geometry of their muscles and dynamics of their joints, one pose or many.

use crate::array::{Rows, array, common_lead, vector};
use crate::controller::Controller;
use crate::failure::Failure;
use crate::long_call;
use numpy::{PyArray1, PyArrayDyn};
use pyo3::prelude::*;
use sinew::body::{Poses, Reduction};
use sinew::control::arm::{ArmGains, synthesize, tension_limits};
use sinew::machine::Routing;
use sinew::muscle::MuscleDynamics;
use sinew::twin::arm::ArmSpecimen;
use sinew_lab::experiment::oracle_models;
use sinew_lab::machine_file::load_machine;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// A machine on cables: bodies, joints, muscles with sheaths, cables and drives.
#[pyclass(frozen, subclass, module = "sinew._sinew")]
pub(crate) struct Machine {
    pub(crate) machine: Arc<sinew::machine::Machine>,
    source: PathBuf,
    muscles_file: Option<PathBuf>,
    routing: Option<String>,
    warnings: Vec<String>,
    /// Working memory of calls that have ended, for those to come.
    idle: Mutex<Vec<MuscleDynamics>>,
}

/// What calls compute in.
struct Borrowed<'a> {
    machine: &'a Machine,
    model: Option<MuscleDynamics>,
}

impl Drop for Borrowed<'_> {
    fn drop(&mut self) {
        self.machine.idle.lock().unwrap_or_else(PoisonError::into_inner).extend(self.model.take());
    }
}

/// Array of numbers as it is returned.
type Array<'py> = PyResult<Bound<'py, PyArrayDyn<f64>>>;

/// File or name of a machine, the file of its muscles, other routes of its cables.
type Source = (PathBuf, Option<PathBuf>, Option<String>);

/// Poses over the ranges for which gains are derived.
const PLACES: usize = 40;

/// Pieces of a cable that slides.
const CELLS: usize = 12;

/// Puts the muscles that are named on other routes.
fn reroute(mut machine: sinew::machine::Machine, text: &str) -> Result<sinew::machine::Machine, Failure> {
    let routes: BTreeMap<String, Routing> =
        serde_json::from_str(text).map_err(|error| Failure::refused(format!("routing: {error}")))?;
    for (name, routing) in routes {
        let tendons = &machine.robot.parts().tendons;
        let muscle = tendons.iter().position(|tendon| tendon.name == name).ok_or_else(|| {
            let known: Vec<&str> = tendons.iter().map(|tendon| tendon.name.as_str()).collect();
            Failure::refused(format!("routing: expected a muscle ({}), but is {name:?}", known.join(", ")))
        })?;
        machine = machine
            .rerouted(muscle, &routing)
            .map_err(|error| Failure::refused(format!("routing[{name:?}]: {error}")))?;
    }
    Ok(machine)
}

impl Machine {
    /// Calls `work` with working memory, which later calls use again.
    fn with_model<T>(&self, work: impl FnOnce(&mut MuscleDynamics) -> PyResult<T>) -> PyResult<T> {
        let idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let model = match idle {
            Some(model) => model,
            None => MuscleDynamics::new(&self.machine.robot).map_err(Failure::from)?,
        };
        let mut borrowed = Borrowed { machine: self, model: Some(model) };
        match &mut borrowed.model {
            Some(model) => work(model),
            None => Err(Failure::Internal("no working memory".into()).into()),
        }
    }

    pub(crate) fn joints(&self) -> usize {
        self.machine.start.len()
    }

    pub(crate) fn muscles(&self) -> usize {
        self.machine.muscles.len()
    }

    /// Evaluates every pose and appends what `write` computes in it.
    fn in_poses<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        tail: &[usize],
        mut write: impl FnMut(&mut MuscleDynamics, &mut [f64]) -> Result<(), sinew::Error> + Send,
    ) -> Array<'py> {
        let rows = Rows::from_python(q, "q", self.joints())?;
        self.over(q.py(), &[&rows], tail, |model, rows, out| {
            model.evaluate(rows[0])?;
            write(model, out)
        })
    }

    /// Computes `tail` numbers for every row of the arguments.
    fn over<'py>(
        &self,
        py: Python<'py>,
        arguments: &[&Rows<'py>],
        tail: &[usize],
        mut work: impl FnMut(&mut MuscleDynamics, &[&[f64]], &mut [f64]) -> Result<(), sinew::Error> + Send,
    ) -> Array<'py> {
        let lead = common_lead(arguments)?;
        let views = arguments.iter().map(|rows| rows.view()).collect::<PyResult<Vec<_>>>()?;
        let (count, width) = (lead.iter().product::<usize>(), tail.iter().product::<usize>());
        let mut out = vec![0.0; count * width];
        self.with_model(|model| {
            let mut rows: Vec<&[f64]> = vec![&[]; views.len()];
            long_call::for_each(py, count, |k| {
                rows.iter_mut().zip(&views).for_each(|(row, view)| *row = view.row(k));
                let out = &mut out[k * width..(k + 1) * width];
                work(model, &rows, out).map_err(|error| long_call::at(count, k, &error))
            })
        })?;
        array(py, out, &lead, tail)
    }

    /// Gains over the whole range of the joints with the cables as designed.
    pub(crate) fn design_gains(machine: &sinew::machine::Machine) -> Result<ArmGains, Failure> {
        let models = oracle_models(&ArmSpecimen::nominal(machine)?);
        Ok(synthesize(machine, &models, &machine.poses(PLACES)?)?.0)
    }

    /// Index of a site, by default of the end point.
    fn site(&self, name: Option<&str>) -> Result<usize, Failure> {
        let robot = &self.machine.robot;
        let known =
            || robot.parts().sites.iter().map(|site| site.name.as_str()).collect::<Vec<_>>().join(", ");
        match name {
            Some(name) => robot
                .site(name)
                .ok_or_else(|| Failure::refused(format!("site: expected one of {}, but is {name}", known()))),
            None => self.machine.payload_site().ok_or_else(|| {
                Failure::refused(format!("site: expected one of {}: the machine has no end point", known()))
            }),
        }
    }
}

#[pymethods]
impl Machine {
    /// Reads a machine; see `sinew.Machine`.
    #[new]
    #[pyo3(signature = (source, *, muscles=None, routing=None))]
    fn new(
        py: Python<'_>,
        source: PathBuf,
        muscles: Option<PathBuf>,
        routing: Option<String>,
    ) -> PyResult<Self> {
        let loaded = py.detach(|| load_machine(&source, muscles.as_deref()).map_err(Failure::from))?;
        let machine = match &routing {
            None => loaded.machine,
            Some(text) => reroute(loaded.machine, text)?,
        };
        Ok(Self {
            machine: Arc::new(machine),
            source,
            muscles_file: muscles,
            routing,
            warnings: loaded.warnings.iter().map(ToString::to_string).collect(),
            idle: Mutex::new(Vec::new()),
        })
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Source)> {
        let this = slf.get();
        let load = slf.py().import("sinew")?.getattr("_load_machine")?;
        Ok((load, (this.source.clone(), this.muscles_file.clone(), this.routing.clone())))
    }

    /// Names of the built-in machines.
    #[staticmethod]
    fn built_in() -> Vec<&'static str> {
        sinew_models::MACHINES.iter().map(|(name, _)| *name).collect()
    }

    /// What its file contains and the reader ignored, in sentences.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        &self.machine.robot.parts().name
    }

    /// Names of the independent joints, in the order of every `q`.
    #[getter]
    fn joint_names(&self) -> Vec<&str> {
        let robot = &self.machine.robot;
        robot
            .independent_joints()
            .into_iter()
            .map(|joint| robot.parts().joints[joint].name.as_str())
            .collect()
    }

    /// Names of the muscles.
    #[getter]
    fn muscle_names(&self) -> Vec<&str> {
        self.machine.robot.parts().tendons.iter().map(|tendon| tendon.name.as_str()).collect()
    }

    /// Names of the sites.
    #[getter]
    fn site_names(&self) -> Vec<&str> {
        self.machine.robot.parts().sites.iter().map(|site| site.name.as_str()).collect()
    }

    /// Names of the closed paths of its end point.
    #[getter]
    fn path_names(&self) -> Vec<&str> {
        self.machine.paths.iter().map(|path| path.name.as_str()).collect()
    }

    /// Pose in which motions start, rad or m, shape `(joints,)`.
    #[getter]
    fn start<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, &self.machine.start)
    }

    /// Ranges of the joints, rad or m, shape `(joints, 2)`; an unlimited joint has an assumed one.
    #[getter]
    fn ranges<'py>(&self, py: Python<'py>) -> Array<'py> {
        let ranges = self.machine.ranges().map_err(Failure::from)?;
        array(py, ranges.concat(), &[ranges.len()], &[2])
    }

    /// Smallest and largest tension at every anchor, N, of the design or of cable and drive, shape
    /// `(muscles, 2)`.
    #[getter]
    fn tension_limits<'py>(&self, py: Python<'py>) -> Array<'py> {
        let laws = self.machine.laws(CELLS).map_err(Failure::from)?;
        let limits = tension_limits(&self.machine, &laws);
        array(py, limits.concat(), &[limits.len()], &[2])
    }

    /// Mass of its moving bodies, kg.
    #[getter]
    fn mass(&self) -> f64 {
        self.machine.robot.moving_mass()
    }

    /// Lengths of the muscles between first and last site, m, shape `(..., muscles)`.
    ///
    /// `q`: coordinates of the independent joints, rad or m, shape `(..., joints)`.
    fn lengths<'py>(&self, q: &Bound<'py, PyAny>) -> Array<'py> {
        self.in_poses(q, &[self.muscles()], |model, out| {
            out.copy_from_slice(model.lengths());
            Ok(())
        })
    }

    /// Moment arms `R = -dl/dq`, m (m/m for slides), shape `(..., muscles, joints)`.
    ///
    /// `q`: shape `(..., joints)`, rad or m.
    fn moment_arms<'py>(&self, q: &Bound<'py, PyAny>) -> Array<'py> {
        self.in_poses(q, &[self.muscles(), self.joints()], |model, out| {
            out.copy_from_slice(model.moment_arms());
            Ok(())
        })
    }

    /// Angles by which the muscles turn at guides and surfaces, rad, shape `(..., muscles)`.
    ///
    /// `q`: shape `(..., joints)`, rad or m.
    fn wrap_angles<'py>(&self, q: &Bound<'py, PyAny>) -> Array<'py> {
        self.in_poses(q, &[self.muscles()], |model, out| {
            out.iter_mut().enumerate().for_each(|(muscle, out)| *out = model.wrap_angle(muscle));
            Ok(())
        })
    }

    /// Tensions at the drives, N, with which the cables begin to slide toward them under tensions at the
    /// anchors, shape `(..., muscles)`: the law of every cable as designed, with the bend of its sheath and
    /// its wrap in the pose.
    ///
    /// `q`: shape `(..., joints)`, rad or m. `tension`: at the anchors, N, shape `(..., muscles)`.
    fn drive_tensions<'py>(&self, q: &Bound<'py, PyAny>, tension: &Bound<'py, PyAny>) -> Array<'py> {
        let (py, muscles) = (q.py(), self.muscles());
        let (q, tension) =
            (Rows::from_python(q, "q", self.joints())?, Rows::from_python(tension, "tension", muscles)?);
        self.over(py, &[&q, &tension], &[muscles], |model, rows, out| {
            model.evaluate(rows[0])?;
            let laws = self.machine.laws_in(model, rows[0], CELLS)?;
            for ((out, law), tension) in out.iter_mut().zip(laws).zip(rows[1]) {
                *out = law.steady(*tension, 0.0, 1.0)?.tension_in;
            }
            Ok(())
        })
    }

    /// Mass matrix `M(q)`, kg m^2 (kg for slides), shape `(..., joints, joints)`.
    ///
    /// `q`: shape `(..., joints)`, rad or m.
    fn mass_matrix<'py>(&self, q: &Bound<'py, PyAny>) -> Array<'py> {
        self.in_poses(q, &[self.joints(), self.joints()], MuscleDynamics::mass_matrix)
    }

    /// Torque that the muscles have to give, `M a + c + g` without the springs and dampers of the joints, N m
    /// or N, shape `(..., joints)`.
    ///
    /// `q`, `v`, `a`: coordinates, velocities and accelerations of the independent joints, rad or m, per s,
    /// per s^2, shapes `(..., joints)`; one of shape `(joints,)` holds for all rows of the others.
    fn inverse_dynamics<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        a: &Bound<'py, PyAny>,
    ) -> Array<'py> {
        let n = self.joints();
        let py = q.py();
        let (q, v, a) =
            (Rows::from_python(q, "q", n)?, Rows::from_python(v, "v", n)?, Rows::from_python(a, "a", n)?);
        self.over(py, &[&q, &v, &a], &[n], |model, rows, out| {
            model.evaluate(rows[0])?;
            model.inverse_dynamics(rows[1], rows[2], out)
        })
    }

    /// Accelerations of the joints under tensions at the anchors, rad/s^2 or m/s^2, shape `(..., joints)`.
    ///
    /// `q`, `v`: shapes `(..., joints)`, rad or m, per s. `tension`: shape `(..., muscles)`, N.
    fn forward_dynamics<'py>(
        &self,
        q: &Bound<'py, PyAny>,
        v: &Bound<'py, PyAny>,
        tension: &Bound<'py, PyAny>,
    ) -> Array<'py> {
        let n = self.joints();
        let py = q.py();
        let (q, v) = (Rows::from_python(q, "q", n)?, Rows::from_python(v, "v", n)?);
        let tension = Rows::from_python(tension, "tension", self.muscles())?;
        self.over(py, &[&q, &v, &tension], &[n], |model, rows, out| {
            model.evaluate(rows[0])?;
            model.forward_dynamics(rows[1], rows[2], None, out)
        })
    }

    /// Position of a site in the world, m, shape `(..., 3)`.
    ///
    /// `q`: shape `(..., joints)`, rad or m. `site`: its name, by default the end point.
    #[pyo3(signature = (q, *, site=None))]
    fn position<'py>(&self, q: &Bound<'py, PyAny>, site: Option<&str>) -> Array<'py> {
        let site = self.site(site)?;
        let robot = &self.machine.robot;
        let mut poses = Poses::new(robot);
        self.in_poses(q, &[3], |model, out| {
            robot.forward_kinematics(model.coordinates(), &mut poses)?;
            out.copy_from_slice(&robot.site_pose(&poses, site).origin);
            Ok(())
        })
    }

    /// Jacobian of a site, shape `(..., 6, joints)`: its velocity in the world, m/s, above its angular
    /// velocity, rad/s, per velocity of every independent joint.
    ///
    /// `q`: shape `(..., joints)`, rad or m. `site`: its name, by default the end point.
    #[pyo3(signature = (q, *, site=None))]
    fn jacobian<'py>(&self, q: &Bound<'py, PyAny>, site: Option<&str>) -> Array<'py> {
        let site = self.site(site)?;
        let robot = &self.machine.robot;
        let body = robot.parts().sites[site].body;
        let nv = robot.nv();
        let (mut poses, mut reduction) = (Poses::new(robot), Reduction::new(robot));
        let mut rows = vec![0.0; 6 * nv];
        self.in_poses(q, &[6, self.joints()], |model, out| {
            robot.forward_kinematics(model.coordinates(), &mut poses)?;
            let point = robot.site_pose(&poses, site).origin;
            let (linear, angular) = rows.split_at_mut(3 * nv);
            robot.jacobian(&poses, body, point, linear, angular)?;
            reduction.update(robot, model.coordinates())?;
            reduction.rows(&rows, out)
        })
    }

    /// A controller in its initial state.
    ///
    /// `seed`: its cables are identified on the bench of the specimen that `Twin(machine, seed)` is; without
    /// a seed they have the designed parameters. `poses`: the gains hold in these, shape `(n, joints)`, rad
    /// or m, by default in the whole range of the joints.
    #[pyo3(signature = (seed=None, *, poses=None))]
    fn controller(
        &self,
        py: Python<'_>,
        seed: Option<u64>,
        poses: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Controller> {
        let n = self.joints();
        let poses = match poses {
            None => self.machine.poses(PLACES).map_err(Failure::from)?,
            Some(given) => {
                let rows = Rows::from_python(given, "poses", n)?;
                let count: usize = rows.lead().iter().product();
                let view = rows.view()?;
                (0..count).map(|k| view.row(k).to_vec()).collect()
            }
        };
        let machine = self.machine.clone();
        long_call::run(py, None, None, move |_| Controller::new(&machine, seed, &poses))
    }
}
