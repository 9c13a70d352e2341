//! Expressions with units, such as `= (spread - 5 mm) / (2 * crank)`, evaluated while they are parsed:
//!
//! * `sum`: `product` { (`+` | `-`) `product` }; `product`: `factor` { (`*` | `/`) `factor` }
//! * `factor`: (`-` | `+`) `factor`, or `atom` with a power: `atom` `^` `factor`
//! * `atom`: number with a unit or without, name, function `(` `sum` { `,` `sum` } `)`, or `(` `sum` `)`
//!
//! A unit follows its number. It has no spaces and is the longest known one: `2 mm/s` is a speed, `2 mm / s` divides 2 mm by
//! the parameter `s`. `g` is the gram.

use std::ops::Range;

use super::measured::{Exponents, Measured};
use super::{Dimension, canonical, number_length, to_si};
use crate::numeric::elementary as libm;

/// Names of the functions that expressions may contain.
pub const FUNCTIONS: [&str; 14] =
    ["sqrt", "abs", "min", "max", "hypot", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "exp", "log"];
/// Maximum length of an expression in bytes, and maximum depth: deeper ones would exhaust the stack.
const MAX_LENGTH: usize = 1000;
const MAX_DEPTH: usize = 50;

/// Reason why an expression has no value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ExpressionError {
    /// This name has no value yet.
    Pending(String),
    /// A name has an invalid value, which has been reported.
    Reported,
    /// A problem at a position in the text, with a remark on the position and a remedy.
    Problem { span: Range<usize>, message: String, label: String, help: String },
}

/// A function that returns the value of a name; the second argument is its position in the text.
pub type Lookup<'a> = dyn Fn(&str, Range<usize>) -> Result<Measured, ExpressionError> + 'a;

/// Whether a text is an expression, that is, begins with `=`.
pub fn is_expression(text: &str) -> bool {
    // Most texts begin with a digit.
    match text.as_bytes().first() {
        Some(first) if !first.is_ascii_whitespace() => *first == b'=',
        _ => text.trim_start().starts_with('='),
    }
}

/// Evaluates an expression.
///
/// # Errors
/// Returns the error of `lookup`, or the first problem: a syntax error, different dimensions, or a result that is not a finite
/// number.
pub fn evaluate(text: &str, lookup: &Lookup<'_>) -> Result<Measured, ExpressionError> {
    let mut reader = Reader { text, at: text.find('=').map_or(0, |at| at + 1), depth: 0, lookup };
    if text.len() > MAX_LENGTH {
        let message = format!("the expression has {} characters, but at most {MAX_LENGTH} are allowed", text.len());
        return refuse(reader.at..text.len(), message, "too long", "name parts of it in [parameters]");
    }
    let result = reader.sum()?;
    let Some(found) = reader.peek() else { return Ok(result.value) };
    let (label, help) = match found {
        ',' => ("a decimal comma?", "write a decimal point: 2.5 mm"),
        ')' => ("no parenthesis is open", "remove it, or open one before"),
        _ => ("an operator is missing", "write + - * / or ^ between two values: 2 * crank"),
    };
    refuse(reader.at..reader.at + found.len_utf8(), format!("`{found}` is unexpected here"), label, help)
}

/// A value with the position of its text.
struct Operand {
    value: Measured,
    span: Range<usize>,
}

type Read = Result<Operand, ExpressionError>;

fn refuse<T>(
    span: Range<usize>,
    message: String,
    label: impl Into<String>,
    help: impl Into<String>,
) -> Result<T, ExpressionError> {
    Err(ExpressionError::Problem { span, message, label: label.into(), help: help.into() })
}

fn is_word(letter: char) -> bool {
    letter.is_alphanumeric() || letter == '_'
}

/// Length of the leading part of a text whose characters satisfy a condition.
fn length(text: &str, condition: impl Fn(char) -> bool) -> usize {
    text.find(|letter| !condition(letter)).unwrap_or(text.len())
}

struct Reader<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
    lookup: &'a Lookup<'a>,
}

impl<'a> Reader<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    /// The next character after spaces.
    fn peek(&mut self) -> Option<char> {
        self.at += length(self.rest(), char::is_whitespace);
        self.rest().chars().next()
    }

    /// Reads one of these operators.
    fn operator(&mut self, operators: &str) -> Option<char> {
        let found = self.peek().filter(|found| operators.contains(*found))?;
        self.at += 1;
        Some(found)
    }

    fn source(&self, operand: &Operand) -> &'a str {
        &self.text[operand.span.clone()]
    }

    /// The result of the text from `start`, if it is finite.
    fn result(&self, start: usize, si: f64, exponents: Exponents) -> Read {
        let span = start..self.text[..self.at].trim_end().len();
        if si.is_finite() {
            return Ok(Operand { value: Measured { si, exponents }, span });
        }
        let message = format!("`{}` is not a finite number", &self.text[span.clone()]);
        refuse(span, message, "not finite", "change the values in it")
    }

    /// Common dimension of values that are added or compared.
    fn common(&self, operands: &[Operand]) -> Result<Exponents, ExpressionError> {
        let (first, mut exponents) = (&operands[0], operands[0].value.exponents);
        for other in operands {
            if !exponents.agrees(other.value.exponents) {
                let [a, b] =
                    [first, other].map(|operand| format!("`{}` is {}", self.source(operand), operand.value.name()));
                let help = match first.value.dimension().filter(|_| other.value.is_number()) {
                    Some(dimension) => format!("write a unit: {} {}", self.source(other), dimension.units()[0].name),
                    None => {
                        "write values of the same dimension; a factor of `1 rad` makes a number an angle".to_string()
                    }
                };
                return refuse(first.span.start..other.span.end, format!("{a}, but {b}"), "different dimensions", help);
            }
            exponents.0[3] = exponents.0[3].min(other.value.exponents.0[3]);
        }
        Ok(exponents)
    }

    fn sum(&mut self) -> Read {
        let mut left = self.product()?;
        while let Some(operator) = self.operator("+-") {
            let operands = [left, self.product()?];
            let exponents = self.common(&operands)?;
            let [a, b] = [0, 1].map(|index| operands[index].value.si);
            left = self.result(operands[0].span.start, if operator == '+' { a + b } else { a - b }, exponents)?;
        }
        Ok(left)
    }

    fn product(&mut self) -> Read {
        let mut left = self.factor()?;
        while let Some(operator) = self.operator("*/") {
            let (start, right) = (left.span.start, self.factor()?);
            let (a, b) = (left.value, right.value);
            if operator == '/' && b.si == 0.0 {
                let [whole, divisor] = [&self.text[start..right.span.end], self.source(&right)];
                let message = format!("`{whole}` divides by 0: `{divisor}` is 0");
                return refuse(right.span, message, "is 0", "change the values in the divisor");
            }
            let (si, power) = if operator == '*' { (a.si * b.si, 1) } else { (a.si / b.si, -1) };
            left = self.result(start, si, a.exponents.plus(b.exponents, power))?;
        }
        Ok(left)
    }

    /// Every recursion passes here.
    fn factor(&mut self) -> Read {
        let sign = self.operator("-+");
        let start = self.at - usize::from(sign.is_some());
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            let message = format!("the expression is nested more than {MAX_DEPTH} times");
            return refuse(self.at..self.text.len(), message, "too deep", "name parts of it in [parameters]");
        }
        let found = if sign.is_some() { self.factor()? } else { self.power()? };
        self.depth -= 1;
        let Measured { si, exponents } = found.value;
        if sign.is_some() { self.result(start, if sign == Some('-') { -si } else { si }, exponents) } else { Ok(found) }
    }

    fn power(&mut self) -> Read {
        let base = self.atom()?;
        if self.operator("^").is_none() {
            return Ok(base);
        }
        let exponent = self.factor()?;
        let (Measured { si, exponents }, n) = (base.value, exponent.value.si);
        let powers = exponents.0.map(|each| f64::from(each) * n);
        let has_dimension = powers.iter().all(|power| (power - power.round()).abs() < 1e-9 && power.abs() < 1e4);
        // The products of an integer power are limited.
        let is_whole = n == n.round() && n.abs() <= 1000.0;
        if !exponent.value.is_number() || !has_dimension || si < 0.0 && !is_whole {
            let describe = |operand: &Operand| format!("`{}` is {}", self.source(operand), operand.value);
            let message = format!("{}, which has no power: {}", describe(&base), describe(&exponent));
            let help =
                "an exponent is a number; that of a quantity is a multiple of 1/2, that of a negative number is whole";
            return refuse(exponent.span, message, "no such power", help);
        }
        let power = if is_whole { libm::powi(si, n as i32) } else { libm::pow(si, n) };
        self.result(base.span.start, power, Exponents(powers.map(|power| power.round() as i32)))
    }

    fn atom(&mut self) -> Read {
        let (next, start) = (self.peek(), self.at);
        match next {
            Some('(') => {
                self.at += 1;
                let inner = self.sum()?;
                self.close(start)?;
                Ok(Operand { span: start..self.at, ..inner })
            }
            Some(digit) if digit.is_ascii_digit() || digit == '.' => self.literal(),
            Some(letter) if is_word(letter) => self.name(),
            _ => {
                let found = next.map_or("the end of the expression".to_string(), |found| format!("`{found}`"));
                let span = start..start + next.map_or(0, char::len_utf8);
                let message = format!("a value is missing before {found}");
                refuse(span, message, "expected a value", "write a number with its unit, a name or a function")
            }
        }
    }

    /// Reads the closing parenthesis of the one at `start`.
    fn close(&mut self, start: usize) -> Result<(), ExpressionError> {
        let is_closed = self.operator(")").is_some();
        let message = || "a parenthesis is not closed".to_string();
        if is_closed { Ok(()) } else { refuse(start..start + 1, message(), "opened here", "add `)`") }
    }

    /// Reads a number with its unit.
    fn literal(&mut self) -> Read {
        let start = self.at;
        let digits = &self.rest()[..number_length(self.rest()).max(1)];
        let from = start + digits.len() + length(&self.rest()[digits.len()..], char::is_whitespace);
        let unit = &self.text[from..];
        let word = length(unit, |letter| is_word(letter) || letter == '°');
        let run = length(unit, |letter| is_word(letter) || "*/^·⋅•×²³°".contains(letter));
        let ends = (1..=run).rev().filter(|end| unit.is_char_boundary(*end) && !unit[*end..].starts_with(is_word));
        let known = |end: usize| {
            let name = canonical(&unit[..end]);
            let all = Dimension::ALL
                .into_iter()
                .flat_map(|dimension| dimension.units().iter().map(move |of| (of, dimension)));
            all.into_iter()
                .find(|(of, _)| of.name == name)
                .map(|(of, dimension)| (from + end, of.factor, Some(dimension)))
        };
        let found = if word == 0 { Some((start + digits.len(), 1.0, None)) } else { ends.filter_map(known).next() };
        let Some((end, factor, dimension)) = found else {
            let name = &unit[..word];
            let help = format!("after a number, write a known unit or an operator: {digits} mm, {digits} * {name}");
            return refuse(from..from + word, format!("unknown unit `{name}`"), "not a unit", help);
        };
        self.at = end;
        if dimension.is_some() && self.peek() == Some('^') {
            let message = format!("`{}^` is the power of the unit or of the quantity", &self.text[start..end]);
            let help = format!("write ({})^2, or a known unit such as mm/s^2", &self.text[start..end]);
            return refuse(start..self.at + 1, message, "ambiguous", help);
        }
        self.result(start, to_si(digits, factor).unwrap_or(f64::NAN), Measured::new(0.0, dimension).exponents)
    }

    /// Reads a name, or a function with its arguments.
    fn name(&mut self) -> Read {
        let start = self.at;
        let name = &self.rest()[..length(self.rest(), is_word)];
        self.at += name.len();
        let span = start..self.at;
        let (is_function, is_call) = (FUNCTIONS.contains(&name), self.peek() == Some('('));
        if name == "pi" && !is_call {
            return self.result(start, std::f64::consts::PI, Exponents::NUMBER);
        }
        match (is_function, is_call) {
            (false, false) => return Ok(Operand { value: (self.lookup)(name, span.clone())?, span }),
            (true, false) => {
                return refuse(span, format!("`{name}` has no argument"), "a function", format!("write {name}(..)"));
            }
            (false, true) => {
                let help = format!("functions: {}; write a product with `*`", FUNCTIONS.join(", "));
                return refuse(span, format!("unknown function `{name}`"), "not a function", help);
            }
            (true, true) => {}
        }
        let (open, mut arguments) = (self.at, Vec::new());
        while self.at == open || self.operator(",").is_some() {
            self.at += usize::from(self.at == open);
            arguments.push(self.sum()?);
        }
        self.close(open)?;
        let is_right = match name {
            "min" | "max" => true,
            "hypot" | "atan2" => arguments.len() == 2,
            _ => arguments.len() == 1,
        };
        if !is_right {
            let message = format!("`{name}` has a wrong number of arguments: {}", arguments.len());
            return refuse(
                start..self.at,
                message,
                "arguments",
                "hypot and atan2 have two, min and max any number, all others one",
            );
        }
        self.call(name, start, &arguments)
    }

    fn call(&self, name: &str, start: usize, arguments: &[Operand]) -> Read {
        let common = self.common(arguments)?;
        let argument = &arguments[0];
        let values = || arguments.iter().map(|argument| argument.value.si);
        let (x, y) = (argument.value.si, arguments[arguments.len() - 1].value.si);
        let (is_number, is_angle) = (common == Exponents::NUMBER, common == Exponents::ANGLE);
        let (is_allowed, expected) = match name {
            "sin" | "cos" | "tan" => (is_number || is_angle, "an angle or a number"),
            "asin" | "acos" => (is_number && x.abs() <= 1.0, "a number from -1 to 1"),
            "atan" | "exp" => (is_number, "a number"),
            "log" => (is_number && x > 0.0, "a number above 0"),
            "sqrt" => {
                (x >= 0.0 && common.0.iter().all(|each| each % 2 == 0), "at least 0, with a dimension that has a root")
            }
            _ => (true, ""),
        };
        if !is_allowed {
            let (source, value) = (self.source(argument), argument.value);
            let message = format!("`{source}` is {value}, but the argument of {name} must be {expected}");
            return refuse(argument.span.clone(), message, "not possible", "change the values in it");
        }
        let (si, exponents) = match name {
            "sqrt" => (x.sqrt(), Exponents(common.0.map(|each| each / 2))),
            "abs" => (x.abs(), common),
            "min" => (values().fold(x, f64::min), common),
            "max" => (values().fold(x, f64::max), common),
            "hypot" => (libm::hypot(x, y), common),
            "sin" => (libm::sin(x), Exponents::NUMBER),
            "cos" => (libm::cos(x), Exponents::NUMBER),
            "tan" => (libm::tan(x), Exponents::NUMBER),
            "asin" => (libm::asin(x), Exponents::ANGLE),
            "acos" => (libm::acos(x), Exponents::ANGLE),
            "atan" => (libm::atan(x), Exponents::ANGLE),
            "atan2" => (libm::atan2(x, y), Exponents::ANGLE),
            "exp" => (libm::exp(x), Exponents::NUMBER),
            _ => (libm::ln(x), Exponents::NUMBER),
        };
        self.result(start, si, exponents)
    }
}

#[cfg(test)]
mod tests {
    use super::super::parse;
    use super::*;
    use proptest::prelude::*;

    /// Parameters of the tests: quantities as written.
    const NAMES: [(&str, &str, Dimension); 8] = [
        ("crank", "40 mm", Dimension::Length),
        ("spread", "20 mm", Dimension::Length),
        ("k", "0.3 N*m/rad", Dimension::AngularStiffness),
        ("tilt", "30 deg", Dimension::Angle),
        ("rate", "2 rad/s", Dimension::AngularRate),
        ("inertia", "3 kg*m^2", Dimension::Inertia),
        ("s", "4 s", Dimension::Time),
        ("m", "2 kg", Dimension::Mass),
    ];

    fn lookup(name: &str, span: Range<usize>) -> Result<Measured, ExpressionError> {
        match NAMES.iter().find(|(known, ..)| *known == name) {
            Some((_, text, dimension)) => {
                Ok(Measured::new(parse(text, *dimension).expect("a quantity"), Some(*dimension)))
            }
            None if name == "pending" => Err(ExpressionError::Pending(name.to_string())),
            None => refuse(span, format!("unknown parameter `{name}`"), "", "remedy"),
        }
    }

    fn value(text: &str) -> Measured {
        evaluate(text, &lookup).unwrap_or_else(|error| panic!("{text}: {error:?}"))
    }

    /// The message of an invalid expression with the text that it marks.
    fn problem(text: &str) -> (String, &str) {
        match evaluate(text, &lookup) {
            Err(ExpressionError::Problem { span, message, label, help }) => {
                assert!(!label.is_empty() && !help.is_empty() || message.starts_with("unknown parameter"), "{text}");
                (message, &text[span])
            }
            other => panic!("{text}: {other:?}"),
        }
    }

    #[track_caller]
    fn assert_number(text: &str, expected: f64) {
        let found = value(text);
        assert!(
            found.is_number() && found.si.to_bits() == expected.to_bits(),
            "{text}: {found:?}, expected {expected:?}"
        );
    }

    #[track_caller]
    fn assert_quantity(text: &str, si: f64, dimension: Dimension) {
        let found = value(text);
        assert!(found.is(Some(dimension)), "{text}: {}", found.name());
        assert!((found.si - si).abs() <= 4.0 * f64::EPSILON * si.abs(), "{text}: {:?}, expected {si:?}", found.si);
    }

    #[test]
    fn operators_have_the_usual_precedence() {
        for (text, expected) in [
            ("= 1 + 2 * 3", 7.0),
            ("=(1+2)*3", 9.0),
            ("= 2 - 3 - 4", -5.0),
            ("= 12 / 3 / 2", 2.0),
            ("= 12 / 3 * 2", 8.0),
            ("= -2^2", -4.0),
            ("= (-2)^2", 4.0),
            ("= 2^3^2", 512.0),
            ("= 2^-1", 0.5),
            ("= -2^-2", -0.25),
            ("= 2 * -3", -6.0),
            ("= --2 + +3", 5.0),
            ("= (-2)^3", -8.0),
            ("= .5e1 + 1.", 6.0),
            (" \t= 1 ", 1.0),
            ("= 2 * pi", std::f64::consts::TAU),
            ("= min(3, 1, 2) + max(3, 1, 2) - abs(-4)", 0.0),
            ("= sqrt(16) + hypot(3, 4)", 9.0),
            ("= 0^0", 1.0),
        ] {
            assert_number(text, expected);
        }
    }

    #[test]
    fn functions_are_those_of_the_project() {
        for (text, expected) in [
            ("= sin(0.3)", libm::sin(0.3)),
            ("= cos(0.3)", libm::cos(0.3)),
            ("= tan(0.3)", libm::tan(0.3)),
            ("= exp(0.3)", libm::exp(0.3)),
            ("= log(0.3)", libm::ln(0.3)),
            ("= 0.3^2.7", libm::pow(0.3, 2.7)),
            ("= asin(0.3) / (1 rad)", libm::asin(0.3)),
            ("= acos(0.3) / (1 rad)", libm::acos(0.3)),
            ("= atan(0.3) / (1 rad)", libm::atan(0.3)),
            ("= atan2(0.3, -2) / (1 rad)", libm::atan2(0.3, -2.0)),
            ("= sin(tilt)", libm::sin(parse("30 deg", Dimension::Angle).expect("an angle"))),
        ] {
            assert_number(text, expected);
        }
        // Every function has at least one valid call.
        for name in FUNCTIONS {
            value(&format!("= {name}(0.5{})", if ["hypot", "atan2"].contains(&name) { ", 0.5" } else { "" }));
        }
    }

    #[test]
    fn literals_equal_quantities_and_a_unit_is_the_longest_known_one() {
        for dimension in Dimension::ALL {
            for unit in dimension.units() {
                // `g` is the gram.
                if (unit.name, dimension) != ("g", Dimension::Acceleration) {
                    let text = format!("4.73 {}", unit.name);
                    let found = value(&format!("= {text}"));
                    assert_eq!(Ok(found.si.to_bits()), parse(&text, dimension).map(f64::to_bits), "{text}");
                    assert!(found.is(Some(dimension)), "{text}");
                }
            }
        }
        assert_quantity("= 2 mm/s", 0.002, Dimension::Speed);
        assert_quantity("= 2 mm / s * 2 s * 2", 0.002, Dimension::Length);
        assert_quantity("= 2 mm/spread*crank", 0.004, Dimension::Length);
        assert_quantity("= 5 N*m", 5.0, Dimension::Torque);
        assert_quantity("= 5 * m", 10.0, Dimension::Mass);
        assert_quantity("= 3 m/s^2*m", 6.0, Dimension::Force);
        assert_quantity("= 90°", std::f64::consts::FRAC_PI_2, Dimension::Angle);
        assert_quantity("= 3µm + 2 μm", 5e-6, Dimension::Length);
        assert_quantity("= 1070 kg/m³ * 1 kg/(1 kg)", 1070.0, Dimension::Density);
        assert_quantity("= (2 mm)^2 / (1 mm)", 0.004, Dimension::Length);
    }

    #[test]
    fn dimensions_follow_from_the_computation() {
        assert_quantity("= (spread - 5 mm) / (2 * crank) * 1 rad", 0.1875, Dimension::Angle);
        assert_quantity("= acos((spread - 5 mm) / (2 * crank))", libm::acos(0.1875), Dimension::Angle);
        assert_quantity("= k * tilt", 0.05 * std::f64::consts::PI, Dimension::Torque);
        assert_quantity("= (k * tilt) / tilt", 0.3, Dimension::AngularStiffness);
        assert_quantity("= crank * tilt + 1 mm", 0.04 * std::f64::consts::FRAC_PI_6 + 0.001, Dimension::Length);
        assert_quantity("= crank * rate", 0.08, Dimension::Speed);
        assert_quantity("= crank * rate^2", 0.16, Dimension::Acceleration);
        assert_quantity("= inertia * rate / s", 1.5, Dimension::Torque);
        assert_quantity("= rate * crank / spread", 4.0, Dimension::AngularRate);
        assert_quantity("= crank * rate / crank", 2.0, Dimension::AngularRate);
        assert_quantity("= sqrt(k * 1 rad / inertia) * 1 rad", 0.1f64.sqrt(), Dimension::AngularRate);
        assert_quantity("= sqrt(crank^2 + spread^2)", libm::hypot(0.04, 0.02), Dimension::Length);
        assert_quantity("= hypot(crank, spread)", libm::hypot(0.04, 0.02), Dimension::Length);
        assert_quantity("= (crank^3)^(1/3)", 0.04, Dimension::Length);
        assert_quantity("= 2 * pi * rate / (2 * pi) / (1 rad)", 2.0, Dimension::Frequency);
        assert_quantity("= m / (crank * spread * 2 mm)", 2.0 / (0.04 * 0.02 * 0.002), Dimension::Density);
        // A radian is not lost: a stiffness is no torque, a number no angle, a frequency no rate.
        for (text, wrong) in [
            ("= k", Dimension::Torque),
            ("= k * tilt", Dimension::AngularStiffness),
            ("= crank / spread", Dimension::Angle),
            ("= 5 Hz", Dimension::AngularRate),
            ("= rate", Dimension::Frequency),
        ] {
            assert!(!value(text).is(Some(wrong)), "{text} {wrong:?}");
        }
        assert_eq!(value("= crank * spread").to_string(), "0.0008 m^2");
        assert_eq!(value("= sqrt(crank)").name(), "a quantity in m^0.5");
    }

    #[test]
    fn problems_name_the_part_and_its_position() {
        for (text, message, marked) in [
            ("= crank + 5", "`crank` is a length, but `5` is a number", "crank + 5"),
            ("= 2 * crank - tilt", "`2 * crank` is a length, but `tilt` is an angle", "2 * crank - tilt"),
            ("= min(1, 2 mm)", "`1` is a number, but `2 mm` is a length", "1, 2 mm"),
            ("= tilt + 1", "`tilt` is an angle, but `1` is a number", "tilt + 1"),
            ("= 1 / (crank - 40 mm)", "`1 / (crank - 40 mm)` divides by 0: `(crank - 40 mm)` is 0", "(crank - 40 mm)"),
            ("= 2 + exp(1e4)", "`exp(1e4)` is not a finite number", "exp(1e4)"),
            ("= 1e999 mm", "`1e999 mm` is not a finite number", "1e999 mm"),
            ("= 0^-1", "`0^-1` is not a finite number", "0^-1"),
            ("= acos(2)", "`2` is 2, but the argument of acos must be a number from -1 to 1", "2"),
            (
                "= sqrt(spread - crank)",
                "`spread - crank` is -20 mm, but the argument of sqrt must be at least 0",
                "spread - crank",
            ),
            (
                "= sqrt(sqrt(crank))",
                "`sqrt(crank)` is 0.2 m^0.5, but the argument of sqrt must be at least 0, with",
                "sqrt(crank)",
            ),
            ("= log(crank)", "`crank` is 40 mm, but the argument of log must be a number above 0", "crank"),
            ("= sin(crank)", "the argument of sin must be an angle or a number", "crank"),
            ("= (-2)^0.5", "`(-2)` is -2, which has no power: `0.5` is 0.5", "0.5"),
            ("= crank^0.3", "`crank` is 40 mm, which has no power: `0.3` is 0.3", "0.3"),
            ("= 2^crank", "`crank` is 40 mm", "crank"),
            ("= 2 mm^2", "`2 mm^` is the power of the unit or of the quantity", "2 mm^"),
            ("= 5 mn", "unknown unit `mn`", "mn"),
            ("= 2 crank", "unknown unit `crank`", "crank"),
            ("= frob(2)", "unknown function `frob`", "frob"),
            ("= crank(2)", "unknown function `crank`", "crank"),
            ("= sin + 1", "`sin` has no argument", "sin"),
            ("= sin(1, 2)", "`sin` has a wrong number of arguments: 2", "sin(1, 2)"),
            ("= atan2(1)", "`atan2` has a wrong number of arguments: 1", "atan2(1)"),
            ("= nothing", "unknown parameter `nothing`", "nothing"),
            ("= (1 + 2", "a parenthesis is not closed", "("),
            ("= sin(1", "a parenthesis is not closed", "("),
            ("= 1 + ", "a value is missing before the end of the expression", ""),
            ("=", "a value is missing before the end of the expression", ""),
            ("= 1 + * 2", "a value is missing before `*`", "*"),
            ("= 2,5", "`,` is unexpected here", ","),
            ("= 2 (3)", "`(` is unexpected here", "("),
            ("= 1)", "`)` is unexpected here", ")"),
            ("= crank spread", "`s` is unexpected here", "s"),
            ("= é", "unknown parameter `é`", "é"),
            ("= 1 ÷ 2", "`÷` is unexpected here", "÷"),
            ("= .", "`.` is not a finite number", "."),
        ] {
            let (found, span) = problem(text);
            assert!(found.contains(message), "{text}: {found}");
            assert_eq!(span, marked, "{text}: {found}");
        }
        assert_eq!(evaluate("= 1 + pending", &lookup), Err(ExpressionError::Pending("pending".to_string())));
        for deep in ["(", "-", "2^", "sin("] {
            let (message, _) = problem(&format!("= {}1", deep.repeat(200)));
            assert!(message.contains("nested more than 50 times"), "{message}");
        }
        assert!(problem(&format!("= {}1", "1 + ".repeat(300))).0.contains("1203 characters, but at most 1000"));
    }

    proptest! {
        #[test]
        fn evaluation_never_panics(text in "\\PC{0,40}", parts in proptest::collection::vec(0usize..30, 0..40)) {
            let _ = evaluate(&text, &lookup);
            // Texts of tokens reach deeper.
            let tokens = [
                "1", "2.5", " ", "(", ")", "+", "-", "*", "/", "^", ",", "mm", "N*m", "°", "²", "crank", "tilt", "k", "s", "pi",
                "sqrt(", "min(", "atan2(", "acos(", "log(", "1e300", "0", "=", "m", "é",
            ];
            let text: String = parts.into_iter().map(|part| tokens[part]).collect();
            if let Ok(found) = evaluate(&format!("={text}"), &lookup) {
                prop_assert!(found.si.is_finite(), "{}", text);
            }
        }

        /// Sums and products of numbers are those of floating-point arithmetic.
        #[test]
        fn numbers_are_computed_as_written(a in -1e3..1e3f64, b in -1e3..1e3f64, c in -1e3..1e3f64) {
            let found = value(&format!("= ({a:?}) * ({b:?}) + ({c:?}) - ({a:?})"));
            prop_assert_eq!(found.si.to_bits(), (a * b + c - a).to_bits());
        }
    }
}
