//! Writes all mutants of a file into it, each behind a comparison with the number of the active one.
//!
//! An expression with mutants becomes `match at(n) { n => mutated, ..., _ => original }`. Only one mutant is active at a time, so
//! that the mutated arms are the original text with one change, and the original arm holds the nested expressions' own mutants.

use crate::mutant::{Genre, Mutant, Place};
use proc_macro2::LineColumn;
use std::collections::{HashMap, HashSet};
use std::fmt::Write;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};

/// Text and the mutants in it, by number.
pub(crate) struct Instrumented {
    pub text: String,
    pub switched: Vec<usize>,
}

/// `source` with those of the `mutants` (number and description) that can be switched at run time and are not `excluded`.
pub(crate) fn instrument(
    source: &str,
    mutants: &[(usize, &Mutant)],
    excluded: &HashSet<usize>,
) -> Result<Instrumented, syn::Error> {
    let syntax = syn::parse_file(source)?;
    let mut at: HashMap<(Place, Group), Vec<(usize, &Mutant)>> = HashMap::new();
    for &(number, mutant) in mutants.iter().filter(|(number, _)| !excluded.contains(number)) {
        at.entry((mutant.span.start, Group::of(mutant.genre))).or_default().push((number, mutant));
    }
    let mut lines = vec![0];
    lines.extend(source.match_indices('\n').map(|(offset, _)| offset + 1));
    let mut instrumentation = Instrumentation {
        source,
        lines,
        at,
        constant: 0,
        edits: Vec::new(),
        switched: Vec::new(),
        constants: HashMap::new(),
    };
    for item in &syntax.items {
        if let syn::Item::Const(constant) = item {
            let mutants = instrumentation.taken(&constant.ident, Group::Constant);
            instrumentation.constants.insert(constant.ident.to_string(), mutants);
        }
    }
    instrumentation.visit_file(&syntax);
    instrumentation.edits.sort_by_key(|edit| edit.0);
    let (mut text, mut end) = (String::new(), 0);
    for (offset, inserted) in &instrumentation.edits {
        text.push_str(&source[end..*offset]);
        text.push_str(inserted);
        end = *offset;
    }
    text.push_str(&source[end..]);
    Ok(Instrumented { text, switched: instrumentation.switched })
}

/// Places can coincide between a function's body and its first expression.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Group {
    Operator,
    Body,
    Guard,
    Arm,
    Field,
    Constant,
}

impl Group {
    fn of(genre: Genre) -> Self {
        match genre {
            Genre::BinaryOperator | Genre::UnaryOperator => Self::Operator,
            Genre::FnValue => Self::Body,
            Genre::MatchArmGuard => Self::Guard,
            Genre::MatchArm => Self::Arm,
            Genre::StructField => Self::Field,
            Genre::Constant => Self::Constant,
        }
    }
}

struct Instrumentation<'a> {
    source: &'a str,
    /// Offset of each line.
    lines: Vec<usize>,
    at: HashMap<(Place, Group), Vec<(usize, &'a Mutant)>>,
    /// Depth of contexts that are evaluated by the compiler, where nothing can be switched.
    constant: usize,
    /// Insertions. At one offset they are in the order in which they were made.
    edits: Vec<(usize, String)>,
    switched: Vec<usize>,
    /// Mutants of the file's constants, by name.
    constants: HashMap<String, Vec<(usize, &'a Mutant)>>,
}

impl<'a> Instrumentation<'a> {
    fn offset(&self, place: LineColumn) -> usize {
        let start = self.lines[place.line - 1];
        let line = &self.source[start..];
        start + line.char_indices().nth(place.column).map_or(line.len(), |(offset, _)| offset)
    }

    fn range(&self, node: &impl Spanned) -> (usize, usize) {
        let span = node.span();
        (self.offset(span.start()), self.offset(span.end()))
    }

    fn text(&self, node: &impl Spanned) -> &'a str {
        let (start, end) = self.range(node);
        &self.source[start..end]
    }

    fn taken(&mut self, node: &impl Spanned, group: Group) -> Vec<(usize, &'a Mutant)> {
        if self.constant > 0 {
            return Vec::new();
        }
        let start = node.span().start();
        let mutants = self
            .at
            .remove(&(Place { line: start.line, column: start.column + 1 }, group))
            .unwrap_or_default();
        self.switched.extend(mutants.iter().map(|mutant| mutant.0));
        mutants
    }

    /// Inserts the arms of `mutated` before `offset`; what follows is the original's arm.
    fn open(&mut self, offset: usize, mutated: &[(usize, String)], closing: &str) {
        let mut text = format!("(match crate::mutants::at({}) {{", mutated[0].0);
        for (number, expression) in mutated {
            let _ = write!(text, "\n/*mutant*/ {number} => {{ {expression}{closing} }} /*{number}*/\n");
        }
        text.push_str("_ => {");
        self.edits.push((offset, text));
    }

    fn close(&mut self, offset: usize, closing: &str) {
        self.edits.push((offset, format!("{closing} }} }})")));
    }

    /// Switches between an expression and its text with another operator at `operator`.
    fn switch(
        &mut self,
        whole: &impl Spanned,
        operator: &impl Spanned,
        closing: &str,
        inside: impl FnOnce(&mut Self),
    ) {
        let mutants = self.taken(operator, Group::Operator);
        if mutants.is_empty() {
            inside(self);
            return;
        }
        let ((start, end), (first, last)) = (self.range(whole), self.range(operator));
        let mutated = |mutant: &Mutant| {
            format!("{}{}{}", &self.source[start..first], mutant.replacement, &self.source[last..end])
        };
        let mutated: Vec<_> = mutants.iter().map(|(number, mutant)| (*number, mutated(mutant))).collect();
        self.open(start, &mutated, closing);
        inside(self);
        self.close(end, closing);
    }

    fn body(&mut self, constant: bool, block: &'a syn::Block) {
        if constant {
            return;
        }
        let Some(first) = block.stmts.first() else { return };
        let mutants = self.taken(first, Group::Body);
        if !mutants.is_empty() {
            let mut text = format!("match crate::mutants::at({}) {{", mutants[0].0);
            for (number, mutant) in &mutants {
                let _ =
                    write!(text, "\n/*mutant*/ {number} => return {}, /*{number}*/\n", mutant.replacement);
            }
            text.push_str("_ => {} }\n");
            let (start, _) = self.range(first);
            self.edits.push((start, text));
        }
    }
}

/// Whether an operand binds by `let`, which an expression of its own cannot.
fn binds(expression: &syn::Expr) -> bool {
    match expression {
        syn::Expr::Let(_) => true,
        syn::Expr::Binary(binary) => binds(&binary.left) || binds(&binary.right),
        _ => false,
    }
}

fn assigns(operator: &syn::BinOp) -> bool {
    use syn::BinOp::*;
    matches!(
        operator,
        AddAssign(_)
            | SubAssign(_)
            | MulAssign(_)
            | DivAssign(_)
            | RemAssign(_)
            | BitXorAssign(_)
            | BitAndAssign(_)
            | BitOrAssign(_)
            | ShlAssign(_)
            | ShrAssign(_)
    )
}

impl<'ast> Visit<'ast> for Instrumentation<'ast> {
    fn visit_expr_binary(&mut self, node: &'ast syn::ExprBinary) {
        if binds(&node.left) || binds(&node.right) {
            visit::visit_expr_binary(self, node);
            return;
        }
        let closing = if assigns(&node.op) { ";" } else { "" };
        self.switch(node, &node.op, closing, |instrumentation| {
            visit::visit_expr_binary(instrumentation, node)
        });
    }

    fn visit_expr_unary(&mut self, node: &'ast syn::ExprUnary) {
        self.switch(node, &node.op, "", |instrumentation| visit::visit_expr_unary(instrumentation, node));
    }

    fn visit_expr_path(&mut self, node: &'ast syn::ExprPath) {
        let Some(mutants) = node.path.get_ident().and_then(|name| self.constants.get(&name.to_string()))
        else {
            return;
        };
        if mutants.is_empty() || self.constant > 0 {
            return;
        }
        let (start, end) = self.range(node);
        let original = self.text(node);
        let mutated: Vec<_> = mutants
            .iter()
            .map(|(number, mutant)| (*number, format!("{original} * {}", mutant.replacement)))
            .collect();
        self.open(start, &mutated, "");
        self.close(end, "");
    }

    fn visit_arm(&mut self, node: &'ast syn::Arm) {
        let guards = match &node.guard {
            Some((_, guard)) if !binds(guard) => self.taken(&**guard, Group::Guard),
            _ => Vec::new(),
        };
        let deleted = self.taken(node, Group::Arm);
        let (_, after_pattern) = self.range(&node.pat);
        match &node.guard {
            Some((_, guard)) => {
                let (start, end) = self.range(&**guard);
                for (number, _) in &deleted {
                    self.edits.push((start, format!("crate::mutants::at({number}) != {number} && ")));
                }
                let mutated: Vec<_> =
                    guards.iter().map(|(number, mutant)| (*number, mutant.replacement.clone())).collect();
                if mutated.is_empty() {
                    visit::visit_expr(self, guard);
                } else {
                    self.open(start, &mutated, "");
                    visit::visit_expr(self, guard);
                    self.close(end, "");
                }
            }
            None => {
                for (number, _) in &deleted {
                    self.edits
                        .push((after_pattern, format!(" if crate::mutants::at({number}) != {number} ")));
                }
            }
        }
        visit::visit_expr(self, &node.body);
    }

    fn visit_expr_struct(&mut self, node: &'ast syn::ExprStruct) {
        for field in &node.fields {
            let deleted = self.taken(field, Group::Field);
            let (Some((number, _)), Some(base), syn::Member::Named(name)) =
                (deleted.first(), &node.rest, &field.member)
            else {
                visit::visit_field_value(self, field);
                continue;
            };
            let (start, end) = self.range(&field.expr);
            if field.colon_token.is_none() {
                self.edits.push((start, format!("{name}: ")));
            }
            self.open(start, &[(*number, format!("({}).{name}", self.text(&**base)))], "");
            visit::visit_expr(self, &field.expr);
            self.close(end, "");
        }
        if let Some(base) = &node.rest {
            visit::visit_expr(self, base);
        }
    }

    fn visit_item_fn(&mut self, node: &'ast syn::ItemFn) {
        let constant = node.sig.constness.is_some();
        self.body(constant, &node.block);
        self.constant += usize::from(constant);
        visit::visit_block(self, &node.block);
        self.constant -= usize::from(constant);
    }

    fn visit_impl_item_fn(&mut self, node: &'ast syn::ImplItemFn) {
        let constant = node.sig.constness.is_some();
        self.body(constant, &node.block);
        self.constant += usize::from(constant);
        visit::visit_block(self, &node.block);
        self.constant -= usize::from(constant);
    }

    fn visit_trait_item_fn(&mut self, node: &'ast syn::TraitItemFn) {
        if let Some(block) = &node.default {
            self.body(false, block);
            visit::visit_block(self, block);
        }
    }

    fn visit_item_const(&mut self, _: &'ast syn::ItemConst) {}
    fn visit_item_static(&mut self, _: &'ast syn::ItemStatic) {}
    fn visit_impl_item_const(&mut self, _: &'ast syn::ImplItemConst) {}
    fn visit_trait_item_const(&mut self, _: &'ast syn::TraitItemConst) {}
    fn visit_expr_const(&mut self, _: &'ast syn::ExprConst) {}
    fn visit_type(&mut self, _: &'ast syn::Type) {}
    fn visit_pat(&mut self, _: &'ast syn::Pat) {}
    fn visit_attribute(&mut self, _: &'ast syn::Attribute) {}
    fn visit_generics(&mut self, _: &'ast syn::Generics) {}

    fn visit_expr_repeat(&mut self, node: &'ast syn::ExprRepeat) {
        visit::visit_expr(self, &node.expr);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mutant::Span;

    fn mutant(line: usize, column: usize, genre: Genre, replacement: &str) -> Mutant {
        let span = Span { start: Place { line, column } };
        Mutant { name: String::new(), file: String::new(), genre, replacement: replacement.to_string(), span }
    }

    fn squeezed(text: &str) -> String {
        text.split_whitespace().collect::<Vec<_>>().join(" ")
    }

    #[test]
    fn nested_operators_are_switched_each_by_itself() {
        let source = "fn f(a: f64) -> f64 {\n    a * 2.0 + 1.0\n}\n";
        let product = mutant(2, 7, Genre::BinaryOperator, "/");
        let sum = mutant(2, 13, Genre::BinaryOperator, "-");
        let result = instrument(source, &[(1, &product), (2, &sum)], &HashSet::new()).expect("valid source");
        assert_eq!(
            squeezed(&result.text),
            "fn f(a: f64) -> f64 { (match crate::mutants::at(2) { /*mutant*/ 2 => { a * 2.0 - 1.0 } /*2*/ _ => {\
             (match crate::mutants::at(1) { /*mutant*/ 1 => { a / 2.0 } /*1*/ _ => {a * 2.0 } }) + 1.0 } }) }"
        );
        assert_eq!(result.switched, [2, 1]);
    }

    #[test]
    fn constants_are_left_alone() {
        let source = "const A: f64 = 1.0 + 1.0;\nconst fn g() -> u8 {\n    1 + 1\n}\n";
        let outside = mutant(1, 20, Genre::BinaryOperator, "-");
        let inside = mutant(3, 7, Genre::BinaryOperator, "-");
        let result =
            instrument(source, &[(1, &outside), (2, &inside)], &HashSet::new()).expect("valid source");
        assert_eq!(result.text, source);
        assert!(result.switched.is_empty());
    }
}
