//! The weighted mean of the members of an estimator.

use super::literal::double;
use super::needs::uses_dt;
use crate::Name;
use sinew::predictor::{Estimator, FADE, Member};
use std::fmt::Write as _;

/// Lines that step every member and add their mean to `s->mean`; nothing without members.
pub(super) fn code(estimator: &Estimator, inputs: usize, name: &Name) -> String {
    let members = || estimator.members.iter().enumerate();
    if estimator.members.is_empty() {
        return String::new();
    }
    let fades = estimator.members.iter().any(|member| member.inside);
    let outside = if fades { "outside, " } else { "" };
    let mut code = format!("    {{\n        double {outside}mean_of, difference;\n");
    code += "        double all = 0.0, total = 0.0, sum = 0.0, weighted_gate = 0.0, between = 0.0;\n";
    for (k, _) in members() {
        let _ = writeln!(code, "        double w{k};");
    }
    code += "        int k;\n";
    for (k, member) in members() {
        let (of, dt) = (name.of_member(k), if uses_dt(&member.estimator) { ", dt_s" } else { "" });
        let _ = write!(
            code,
            "        for (k = 0; k < {inputs}; k++) {{\n            s->m{k}.values[k] = s->values[k];\n        }}\n        \
             s->m{k}.memory_started = began && s->m{k}.memory_started;\n        \
             {}_estimate(&s->m{k}{dt});\n        s->clipped += s->m{k}.clipped;\n",
            of.as_str()
        );
        if !member.inside {
            let _ = writeln!(
                code,
                "        s->beyond = s->m{k}.beyond > s->beyond ? s->m{k}.beyond : s->beyond;"
            );
        }
        let _ = writeln!(code, "        s->determined = s->determined && s->m{k}.determined;");
    }
    if fades {
        let _ = writeln!(code, "        outside = 1.0 - s->beyond / {};", double(FADE));
        code += "        outside = outside > 0.0 ? outside : 0.0;\n";
    }
    for (k, Member { weight, inside, .. }) in members() {
        let factor = if *inside { "outside" } else { "1.0" };
        let weight = double(*weight);
        let _ = write!(
            code,
            "        w{k} = {weight} * {factor};\n        all += {weight};\n        total += w{k};\n        \
             sum += w{k} * s->m{k}.mean;\n        weighted_gate += w{k} * s->m{k}.gate;\n"
        );
    }
    code += "        total = total > DBL_MIN ? total : DBL_MIN;\n        mean_of = sum / total;\n";
    for (k, _) in members() {
        let sigma = format!("{}_sigma", name.of_member(k).as_str());
        let _ = write!(
            code,
            "        difference = s->m{k}.mean - mean_of;\n        \
             between += w{k} * (difference * difference + s->m{k}.variance - {sigma} * {sigma});\n"
        );
    }
    code += "        between = between / total;\n        s->mean += all * mean_of;\n        \
             s->variance += between > 0.0 ? between : 0.0;\n        s->gate = weighted_gate / total;\n    }\n";
    code
}
