//! Where the objects of a drive are in its dictionary.

use crate::dictionary::{Dictionary, Slot};

/// Slots of the objects that a drive works with; a drive may lack any of them.
#[derive(Debug, Clone)]
pub(super) struct Objects {
    pub(super) error_register: Option<Slot>,
    pub(super) error_code: Option<Slot>,
    pub(super) controlword: Option<Slot>,
    pub(super) statusword: Option<Slot>,
    pub(super) quick_stop_option: Option<Slot>,
    pub(super) fault_option: Option<Slot>,
    pub(super) mode: Option<Slot>,
    pub(super) mode_display: Option<Slot>,
    pub(super) position_demand: Option<Slot>,
    pub(super) position: Option<Slot>,
    pub(super) following_window: Option<Slot>,
    pub(super) following_timeout: Option<Slot>,
    pub(super) velocity: Option<Slot>,
    pub(super) target_torque: Option<Slot>,
    pub(super) max_torque: Option<Slot>,
    pub(super) torque: Option<Slot>,
    pub(super) target_position: Option<Slot>,
    pub(super) min_position: Option<Slot>,
    pub(super) max_position: Option<Slot>,
    pub(super) max_speed: Option<Slot>,
    pub(super) increments: Option<Slot>,
    pub(super) revolutions: Option<Slot>,
    pub(super) velocity_offset: Option<Slot>,
    pub(super) torque_offset: Option<Slot>,
    pub(super) following_error: Option<Slot>,
    pub(super) target_velocity: Option<Slot>,
}

impl Objects {
    pub(super) fn find(dictionary: &Dictionary) -> Self {
        let slot = |index| dictionary.slot(index, 0);
        Self {
            error_register: slot(0x1001),
            error_code: slot(0x603f),
            controlword: slot(0x6040),
            statusword: slot(0x6041),
            quick_stop_option: slot(0x605a),
            fault_option: slot(0x605e),
            mode: slot(0x6060),
            mode_display: slot(0x6061),
            position_demand: slot(0x6062),
            position: slot(0x6064),
            following_window: slot(0x6065),
            following_timeout: slot(0x6066),
            velocity: slot(0x606c),
            target_torque: slot(0x6071),
            max_torque: slot(0x6072),
            torque: slot(0x6077),
            target_position: slot(0x607a),
            min_position: dictionary.slot(0x607d, 1),
            max_position: dictionary.slot(0x607d, 2),
            max_speed: slot(0x6080),
            increments: dictionary.slot(0x608f, 1),
            revolutions: dictionary.slot(0x608f, 2),
            velocity_offset: slot(0x60b1),
            torque_offset: slot(0x60b2),
            following_error: slot(0x60f4),
            target_velocity: slot(0x60ff),
        }
    }
}
