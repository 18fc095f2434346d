//! `terminalsAndIcons.xml`: variables that belong to one end or part.

use super::description::{Description, escaped};
use std::collections::BTreeMap;

impl Description {
    /// The terminals of FMI 3.0.
    pub(super) fn terminals(&self) -> String {
        let mut terminals: BTreeMap<&str, String> = BTreeMap::new();
        for variable in &self.variables {
            let Some((terminal, member)) = &variable.terminal else { continue };
            let line = format!(
                "      <TerminalMemberVariable variableName=\"{}\" memberName=\"{}\" variableKind=\"signal\"/>\n",
                escaped(&variable.name),
                escaped(member)
            );
            terminals.entry(terminal).or_default().push_str(&line);
        }
        let terminal = |(name, members): (&&str, &String)| {
            format!(
                "    <Terminal name=\"{}\" matchingRule=\"bus\">\n{members}    </Terminal>\n",
                escaped(name)
            )
        };
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiTerminalsAndIcons fmiVersion=\"3.0\">\n  \
             <Terminals>\n{}  </Terminals>\n</fmiTerminalsAndIcons>\n",
            terminals.iter().map(terminal).collect::<String>()
        )
    }
}
