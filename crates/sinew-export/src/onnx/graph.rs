//! A graph of ONNX under construction: every value is a table of one row for each sequence.

use super::protobuf::Message;
use std::collections::BTreeMap;

/// A value of the graph.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Value(usize);

/// What a table holds, as ONNX counts types.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    Single = 1,
    Whole = 7,
    Double = 11,
}

/// A part of the state: what it was before the sample, and what it is after it once that is set.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slot {
    pub(super) before: Value,
    index: usize,
}

/// The graph.
#[derive(Debug, Default)]
pub(super) struct Graph {
    names: Vec<String>,
    constants: BTreeMap<(Kind, Vec<u8>), Value>,
    tensors: Vec<Message>,
    nodes: Vec<Message>,
    /// Width and value after the sample of every part of the state.
    slots: Vec<(usize, Value, Option<Value>)>,
}

impl Graph {
    /// A value that comes from outside.
    pub(super) fn input(&mut self, name: &str) -> Value {
        self.names.push(name.to_owned());
        Value(self.names.len() - 1)
    }

    fn fresh(&mut self) -> Value {
        self.input(&format!("v{}", self.names.len()))
    }

    /// The result of an operator.
    pub(super) fn op(&mut self, operator: &str, operands: &[Value]) -> Value {
        self.node(operator, operands, 1, &[])[0]
    }

    /// The results of an operator with attributes, which are whole numbers.
    pub(super) fn node(
        &mut self,
        operator: &str,
        operands: &[Value],
        results: usize,
        attributes: &[(&str, usize)],
    ) -> Vec<Value> {
        const WHOLE: usize = 2;
        let results: Vec<Value> = (0..results).map(|_| self.fresh()).collect();
        let name = |message: Message, field, v: &Value| message.bytes(field, &self.names[v.0]);
        let node = operands.iter().fold(Message::default(), |node, v| name(node, 1, v));
        let node = results.iter().fold(node, |node, v| name(node, 2, v)).bytes(4, operator);
        let attribute = |(name, value): &(&str, usize)| {
            Message::default().bytes(1, name).number(3, *value).number(20, WHOLE)
        };
        let attributes: Vec<Message> = attributes.iter().map(attribute).collect();
        self.nodes.push(node.messages(5, &attributes));
        results
    }

    fn constant(&mut self, kind: Kind, length: usize, bytes: Vec<u8>) -> Value {
        if let Some(value) = self.constants.get(&(kind, bytes.clone())) {
            return *value;
        }
        let value = self.fresh();
        let tensor = Message::default().number(1, length).number(2, kind as usize);
        self.tensors.push(tensor.bytes(8, &self.names[value.0]).bytes(9, &bytes));
        self.constants.insert((kind, bytes), value);
        value
    }

    /// A row of constants.
    pub(super) fn doubles(&mut self, row: &[f64]) -> Value {
        self.constant(Kind::Double, row.len(), row.iter().flat_map(|x| x.to_le_bytes()).collect())
    }

    /// One constant.
    pub(super) fn double(&mut self, x: f64) -> Value {
        self.doubles(&[x])
    }

    /// A row of constants in single precision.
    pub(super) fn singles(&mut self, row: &[f32]) -> Value {
        self.constant(Kind::Single, row.len(), row.iter().flat_map(|x| x.to_le_bytes()).collect())
    }

    /// A row of whole constants.
    pub(super) fn wholes(&mut self, row: &[usize]) -> Value {
        self.constant(Kind::Whole, row.len(), row.iter().flat_map(|x| (*x as u64).to_le_bytes()).collect())
    }

    /// As numbers of a kind; of a truth value 0 or 1.
    pub(super) fn cast(&mut self, value: Value, kind: Kind) -> Value {
        self.node("Cast", &[value], 1, &[("to", kind as usize)])[0]
    }

    /// `a` where a condition holds, else `b`.
    pub(super) fn select(&mut self, condition: Value, a: Value, b: Value) -> Value {
        self.op("Where", &[condition, a, b])
    }

    /// The larger of two; the second where they are equal.
    pub(super) fn larger(&mut self, a: Value, b: Value) -> Value {
        let above = self.op("Greater", &[a, b]);
        self.select(above, a, b)
    }

    /// The smaller of two; the second where they are equal.
    pub(super) fn smaller(&mut self, a: Value, b: Value) -> Value {
        let below = self.op("Less", &[a, b]);
        self.select(below, a, b)
    }

    /// `x` limited to `low <= high`.
    pub(super) fn saturate(&mut self, x: Value, low: Value, high: Value) -> Value {
        let above = self.larger(x, low);
        self.smaller(above, high)
    }

    /// Whether any entry of every row holds.
    pub(super) fn any(&mut self, row: Value) -> Value {
        let numbers = self.cast(row, Kind::Double);
        let (most, zero) = (self.largest(numbers), self.double(0.0));
        self.op("Greater", &[most, zero])
    }

    /// The largest entry of every row.
    pub(super) fn largest(&mut self, row: Value) -> Value {
        let axis = self.wholes(&[1]);
        self.op("ReduceMax", &[row, axis])
    }

    /// The columns of a table, or groups of them; the table itself where there is one.
    pub(super) fn split(&mut self, table: Value, widths: &[usize]) -> Vec<Value> {
        if widths.len() == 1 {
            return vec![table];
        }
        let sizes = self.wholes(widths);
        self.node("Split", &[table, sizes], widths.len(), &[("axis", 1)])
    }

    /// Tables side by side.
    pub(super) fn join(&mut self, parts: &[Value]) -> Value {
        match parts {
            [one] => *one,
            _ => self.node("Concat", parts, 1, &[("axis", 1)])[0],
        }
    }

    /// A new part of the state; all parts are zero before the first sample.
    pub(super) fn remember(&mut self, width: usize) -> Slot {
        let before = self.fresh();
        self.slots.push((width, before, None));
        Slot { before, index: self.slots.len() - 1 }
    }

    /// Sets a part of the state after the sample.
    pub(super) fn keep(&mut self, slot: Slot, after: Value) {
        self.slots[slot.index].2 = Some(after);
    }

    /// Numbers in the state.
    pub(super) fn width(&self) -> usize {
        self.slots.iter().map(|(width, ..)| width).sum()
    }

    /// The state after the sample.
    pub(super) fn state_after(&mut self) -> Value {
        let parts: Vec<Value> =
            self.slots.iter().map(|(_, before, after)| after.unwrap_or(*before)).collect();
        self.join(&parts)
    }

    /// The graph's message, given the state before the sample, what goes in and what comes out: name,
    /// value, type, columns, description.
    pub(super) fn finish(mut self, name: &str, state: Value, ends: [&[End<'_>]; 2]) -> Message {
        // What splits the state stands first: every node comes after those whose results it reads.
        let nodes = std::mem::take(&mut self.nodes);
        let sizes: Vec<usize> = self.slots.iter().map(|(width, ..)| *width).collect();
        let parts = self.split(state, &sizes);
        let earlier: Vec<Value> = self.slots.iter().map(|(_, before, _)| *before).collect();
        for (part, before) in parts.into_iter().zip(earlier) {
            self.alias(part, before);
        }
        self.nodes.extend(nodes);
        for end in ends[1] {
            let output = self.input(end.name);
            self.alias(end.value, output);
        }
        let [inputs, outputs] = ends.map(|list| list.iter().map(End::message).collect::<Vec<_>>());
        let graph = Message::default().messages(1, &self.nodes).bytes(2, name).messages(5, &self.tensors);
        graph.messages(11, &inputs).messages(12, &outputs)
    }

    fn alias(&mut self, from: Value, to: Value) {
        let node = Message::default().bytes(1, &self.names[from.0]).bytes(2, &self.names[to.0]);
        self.nodes.push(node.bytes(4, "Identity"));
    }
}

/// An input or output of the graph.
pub(super) struct End<'a> {
    pub(super) name: &'a str,
    pub(super) value: Value,
    pub(super) kind: Kind,
    pub(super) width: usize,
    pub(super) description: &'a str,
}

impl End<'_> {
    fn message(&self) -> Message {
        let rows = Message::default().bytes(2, "sequences");
        let columns = Message::default().number(1, self.width);
        let shape = Message::default().message(1, &rows).message(1, &columns);
        let tensor = Message::default().number(1, self.kind as usize).message(2, &shape);
        let kind = Message::default().message(1, &tensor);
        Message::default().bytes(1, self.name).message(2, &kind).bytes(3, self.description)
    }
}
