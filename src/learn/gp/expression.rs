//! Kernel expressions: `se_ard + linear`, `(matern52 + constant) * periodic[1-4]`.
//!
//! ```text
//! expression = product { "+" product }
//! product    = factor { "*" factor }
//! factor     = "(" expression ")" | kernel [ "[" inputs "]" ]
//! inputs     = "tendons" | "place" | number [ "-" number ] { "," number [ "-" number ] }
//! ```
//!
//! Inputs count from 1. `place` is the last three, the simulated position of an error model;
//! `tendons` are those before.

use super::kernels::{self, FACTORS, Kernel};
use crate::learn::LearnError;

/// Most factors of an expression after sums are multiplied out.
const MAX_FACTORS: usize = 32;

/// A parsed expression: a sum of products of factors.
#[derive(Clone, Debug, PartialEq)]
pub struct KernelExpression {
    /// The expression with registered names and single blanks.
    text: String,
    /// Distinct factors, in order.
    pub(super) factors: Vec<Factor>,
    /// Factors of each product, as indices into `factors`.
    pub(super) products: Vec<Vec<usize>>,
}

/// A kernel on some of the inputs.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Factor {
    /// Its registered name.
    pub(super) kernel: &'static str,
    pub(super) inputs: Inputs,
}

/// Which inputs a factor sees.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Inputs {
    All,
    Tendons,
    Place,
    /// Ranges from 1, ends included.
    Ranges(Vec<(usize, usize)>),
}

/// Inputs of a position.
const PLACE: usize = 3;

impl Inputs {
    /// The inputs from 0 among `count`.
    pub(super) fn of(&self, count: usize) -> Result<Vec<usize>, LearnError> {
        let refuse =
            |found: String, expected| Err(LearnError::Setting { key: "kernel", found, expected });
        match self {
            Inputs::All => Ok((0..count).collect()),
            Inputs::Tendons | Inputs::Place if count <= PLACE => refuse(
                format!("{self} of {count} inputs"),
                "more than three inputs, the last three a position",
            ),
            Inputs::Tendons => Ok((0..count - PLACE).collect()),
            Inputs::Place => Ok((count - PLACE..count).collect()),
            Inputs::Ranges(ranges) => {
                let inputs: Vec<usize> =
                    ranges.iter().flat_map(|&(first, last)| first - 1..last).collect();
                match inputs.iter().find(|&&input| input >= count) {
                    Some(input) => refuse(
                        format!("input {} of {count}", input + 1),
                        "inputs that the samples have",
                    ),
                    None => Ok(inputs),
                }
            }
        }
    }
}

impl std::fmt::Display for Inputs {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Inputs::All => Ok(()),
            Inputs::Tendons => f.write_str("[tendons]"),
            Inputs::Place => f.write_str("[place]"),
            Inputs::Ranges(ranges) => {
                let range = |&(first, last): &(usize, usize)| {
                    if first == last { first.to_string() } else { format!("{first}-{last}") }
                };
                write!(f, "[{}]", ranges.iter().map(range).collect::<Vec<_>>().join(", "))
            }
        }
    }
}

/// Where an expression does not parse.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{what}{}", self.pointer())]
pub struct ExpressionError {
    /// What was found and what was expected.
    pub what: String,
    /// The expression.
    pub text: String,
    /// Column of the place, from 1.
    pub column: usize,
}

impl ExpressionError {
    /// The expression with a caret under the place; nothing where it is a single name.
    fn pointer(&self) -> String {
        if self.column == 1 && self.text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
            return String::new();
        }
        format!("\n  {}\n  {:>width$}", self.text, "^", width = self.column)
    }
}

impl KernelExpression {
    /// Parses an expression.
    ///
    /// # Errors
    /// [`ExpressionError`] with the place of the first fault.
    pub fn parse(text: &str) -> Result<KernelExpression, ExpressionError> {
        let mut parser = Parser { text, at: 0, factors: Vec::new() };
        let sum = parser.sum()?;
        if parser.peek().is_some() {
            return Err(parser.error("expected `+`, `*` or the end"));
        }
        Ok(KernelExpression { text: sum.text, factors: parser.factors, products: sum.products })
    }

    /// One stationary kernel on all inputs.
    pub fn of(kernel: &'static dyn Kernel) -> KernelExpression {
        let factor = Factor { kernel: kernel.name(), inputs: Inputs::All };
        KernelExpression {
            text: kernel.name().to_owned(),
            factors: vec![factor],
            products: vec![vec![0]],
        }
    }

    /// The expression with registered names.
    pub fn name(&self) -> &str {
        &self.text
    }

    /// The kernel, if the expression is one stationary kernel on all inputs.
    pub fn stationary(&self) -> Option<&'static dyn Kernel> {
        match &self.factors[..] {
            [Factor { kernel, inputs: Inputs::All }] => kernels::find(kernel),
            _ => None,
        }
    }

    /// Refuses an expression that names inputs which samples of `count` inputs do not have.
    ///
    /// # Errors
    /// [`LearnError::Setting`] with the inputs.
    pub fn check_inputs(&self, count: usize) -> Result<(), LearnError> {
        self.factors.iter().try_for_each(|factor| factor.inputs.of(count).map(drop))
    }
}

/// A parsed part: its text and its sum of products.
struct ParsedPart {
    text: String,
    products: Vec<Vec<usize>>,
}

struct Parser<'a> {
    text: &'a str,
    /// Byte offset of the next character.
    at: usize,
    factors: Vec<Factor>,
}

impl Parser<'_> {
    fn sum(&mut self) -> Result<ParsedPart, ExpressionError> {
        let mut sum = self.product()?;
        while self.takes('+') {
            let next = self.product()?;
            sum.text = format!("{} + {}", sum.text, next.text);
            sum.products.extend(next.products);
        }
        Ok(sum)
    }

    fn product(&mut self) -> Result<ParsedPart, ExpressionError> {
        let mut product = self.factor()?;
        while self.takes('*') {
            let next = self.factor()?;
            // Distributive law: every product of the left with every one of the right.
            let pairs = product
                .products
                .iter()
                .flat_map(|a| next.products.iter().map(move |b| [&a[..], b].concat()));
            product = ParsedPart {
                text: format!("{} * {}", product.text, next.text),
                products: pairs.collect(),
            };
            // Nested sums multiply out exponentially.
            if product.products.iter().map(Vec::len).sum::<usize>() > MAX_FACTORS {
                return Err(self.error(
                    "too many products: expected at most 32 factors after sums are multiplied out",
                ));
            }
        }
        Ok(product)
    }

    fn factor(&mut self) -> Result<ParsedPart, ExpressionError> {
        if self.takes('(') {
            let inner = self.sum()?;
            if !self.takes(')') {
                return Err(self.error("expected `)`"));
            }
            let text =
                if inner.products.len() > 1 { format!("({})", inner.text) } else { inner.text };
            return Ok(ParsedPart { text, ..inner });
        }
        let start = self.peek_at();
        let word = self.word();
        if word.is_empty() {
            return Err(self.error("expected a kernel or `(`"));
        }
        let name = kernels::find(&word).map(|kernel| kernel.name());
        let name =
            name.or_else(|| FACTORS.iter().map(|factor| factor.name()).find(|name| *name == word));
        let Some(kernel) = name else {
            let names: Vec<&str> = kernels::names().collect();
            self.at = start;
            return Err(self
                .error(&format!("unknown kernel `{word}`, expected one of {}", names.join(", "))));
        };
        let inputs = if self.takes('[') { self.inputs()? } else { Inputs::All };
        let text = format!("{kernel}{inputs}");
        self.factors.push(Factor { kernel, inputs });
        if self.factors.len() > MAX_FACTORS {
            return Err(self.error("too many kernels: expected at most 32"));
        }
        Ok(ParsedPart { text, products: vec![vec![self.factors.len() - 1]] })
    }

    fn inputs(&mut self) -> Result<Inputs, ExpressionError> {
        let start = self.peek_at();
        let named = match self.word().as_str() {
            "tendons" => Some(Inputs::Tendons),
            "place" => Some(Inputs::Place),
            _ => None,
        };
        let inputs = match named {
            Some(named) => named,
            None => {
                self.at = start;
                Inputs::Ranges(self.ranges()?)
            }
        };
        if self.takes(']') { Ok(inputs) } else { Err(self.error("expected `,` or `]`")) }
    }

    fn ranges(&mut self) -> Result<Vec<(usize, usize)>, ExpressionError> {
        let mut ranges: Vec<(usize, usize)> = Vec::new();
        loop {
            let place = self.peek_at();
            let first = self.number()?;
            let last = if self.takes('-') { self.number()? } else { first };
            let overlaps = ranges.iter().any(|&(from, to)| first <= to && from <= last);
            if last < first || overlaps {
                self.at = place;
                return Err(self.error("expected each input once, in increasing ranges"));
            }
            ranges.push((first, last));
            if !self.takes(',') {
                return Ok(ranges);
            }
        }
    }

    fn number(&mut self) -> Result<usize, ExpressionError> {
        let start = self.peek_at();
        let word = self.word();
        let number = word.parse().ok().filter(|number| (1..=1000).contains(number));
        number.ok_or_else(|| {
            self.at = start;
            self.error("expected `tendons`, `place` or numbers of inputs, from 1")
        })
    }

    /// Letters, digits and `_`.
    fn word(&mut self) -> String {
        let start = self.peek_at();
        let remaining = &self.text[start..];
        let length = remaining
            .find(|c: char| !(c.is_ascii_alphanumeric() || c == '_'))
            .unwrap_or(remaining.len());
        self.at = start + length;
        remaining[..length].to_owned()
    }

    /// Offset of the next character that is not blank.
    fn peek_at(&mut self) -> usize {
        let remaining = &self.text[self.at..];
        self.at += remaining.len() - remaining.trim_start().len();
        self.at
    }

    fn peek(&mut self) -> Option<char> {
        let at = self.peek_at();
        self.text[at..].chars().next()
    }

    fn takes(&mut self, expected: char) -> bool {
        let matches = self.peek() == Some(expected);
        self.at += if matches { expected.len_utf8() } else { 0 };
        matches
    }

    fn error(&mut self, expected: &str) -> ExpressionError {
        let next = self.peek();
        let what = match next {
            Some(next) if expected.starts_with("expected") => format!("found `{next}`, {expected}"),
            None if expected.starts_with("expected") => format!("the expression ends, {expected}"),
            _ => expected.to_owned(),
        };
        let column = self.text[..self.at].chars().count() + 1;
        ExpressionError { what, text: self.text.to_owned(), column }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_of_products_are_multiplied_out_and_share_their_factors() {
        let parsed =
            KernelExpression::parse(" ( se+linear[place] ) *periodic[1-2,4]+ white").unwrap();
        assert_eq!(parsed.name(), "(se_ard + linear[place]) * periodic[1-2, 4] + white");
        assert_eq!(parsed.products, [vec![0, 2], vec![1, 2], vec![3]]);
        assert_eq!(parsed.factors[2].inputs.of(7).unwrap(), [0, 1, 3]);
        assert_eq!(parsed.factors[1].inputs.of(7).unwrap(), [4, 5, 6]);
        assert_eq!(KernelExpression::parse(parsed.name()).unwrap(), parsed, "its text is itself");
        assert!(parsed.stationary().is_none());
        assert_eq!(
            KernelExpression::parse("((matern52))").unwrap().stationary().unwrap().name(),
            "matern52_ard"
        );
    }

    #[test]
    fn the_place_of_a_fault_is_told() {
        for (text, column, what) in [
            ("se_ard +", 9, "the expression ends"),
            ("se_ard + foo", 10, "unknown kernel `foo`"),
            ("se_ard linear", 8, "found `l`, expected `+`"),
            ("(se_ard", 8, "expected `)`"),
            ("se_ard[0]", 8, "from 1"),
            ("se_ard[2-1]", 8, "increasing"),
            ("se_ard[1, 1-2]", 11, "once"),
            ("se_ard[1", 9, "`]`"),
            ("", 1, "expected a kernel"),
            ("é + se", 1, "expected a kernel"),
        ] {
            let error = KernelExpression::parse(text).unwrap_err();
            assert!(error.column == column && error.what.contains(what), "{text}: {error:?}");
            assert!(
                text.is_empty() || error.to_string().lines().last().unwrap().ends_with('^'),
                "{error}"
            );
        }
    }

    #[test]
    fn inputs_that_do_not_exist_are_refused() {
        let expression = KernelExpression::parse("linear[5]").unwrap();
        assert!(expression.check_inputs(5).is_ok() && expression.check_inputs(4).is_err());
        assert!(KernelExpression::parse("linear[place]").unwrap().check_inputs(3).is_err());
    }
}
