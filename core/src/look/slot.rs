//! A rendering question as panels and the command line see it: choices with names, parameters with ranges and units, and
//! setting either from text. [`super::Look::slots`] is made of these.

use serde::{Deserialize, Serialize};

/// The name, label and help of one choice of a slot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ChoiceInfo {
    /// What `--set` takes: lower case with hyphens.
    pub name: &'static str,
    pub label: &'static str,
    pub help: &'static str,
}

/// An enum of alternatives for one question.
pub trait Choice: Copy + PartialEq + 'static {
    const ALL: &'static [Self];
    fn info(self) -> ChoiceInfo;
}

/// A choice seen without its type, for panels and the command line.
pub trait AnyChoice {
    fn index(&self) -> usize;
    fn set_index(&mut self, index: usize);
    fn infos(&self) -> Vec<ChoiceInfo>;
}

impl<C: Choice> AnyChoice for C {
    fn index(&self) -> usize {
        C::ALL.iter().position(|choice| choice == self).unwrap_or(0)
    }
    fn set_index(&mut self, index: usize) {
        *self = C::ALL[index];
    }
    fn infos(&self) -> Vec<ChoiceInfo> {
        C::ALL.iter().map(|choice| choice.info()).collect()
    }
}

macro_rules! choices {
    ($(#[$meta:meta])* $name:ident { $($(#[$variant_meta:meta])* $variant:ident = $key:literal, $label:literal, $help:literal;)+ }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
        pub enum $name { $($(#[$variant_meta])* $variant),+ }
        impl Choice for $name {
            const ALL: &'static [Self] = &[$(Self::$variant),+];
            fn info(self) -> ChoiceInfo {
                match self { $(Self::$variant => ChoiceInfo { name: $key, label: $label, help: $help }),+ }
            }
        }
    };
}

pub(crate) use choices;

choices! {
    /// A switch with a shader of its own for each state.
    Switch {
        On = "on", "On", "Computed";
        Off = "off", "Off", "Left out";
    }
}

/// A number or colour of the look, as panels and `--set` reach it.
pub enum ParamValue<'a> {
    F32(&'a mut f32),
    U32(&'a mut u32),
    /// Linear RGB.
    Colour(&'a mut [f32; 3]),
    /// One of a few, where a shader of its own for each would be too much.
    Choice(&'a mut dyn AnyChoice),
}

impl ParamValue<'_> {
    /// As `--set` takes it and as `--json` prints it.
    pub fn to_text(&self) -> String {
        match self {
            Self::F32(value) => value.to_string(),
            Self::U32(value) => value.to_string(),
            Self::Colour([r, g, b]) => format!("{r},{g},{b}"),
            Self::Choice(choice) => choice.infos()[choice.index()].name.to_owned(),
        }
    }
}

/// One parameter of one choice (or of the whole slot).
pub struct Param<'a> {
    /// `slot.name`, what `--set` takes.
    pub key: String,
    pub label: &'static str,
    /// Empty for a bare number.
    pub unit: &'static str,
    pub min: f32,
    pub max: f32,
    pub help: &'static str,
    /// The choices (by name) that the parameter belongs to; empty: all of them.
    pub of: &'static [&'static str],
    pub value: ParamValue<'a>,
}

impl Param<'_> {
    /// Take a value as [`ParamValue::to_text`] writes it; out of range or not a number is refused.
    pub fn set_from_text(&mut self, value: &str) -> Result<(), SetError> {
        let (min, max) = (self.min, self.max);
        let bad = |takes: String| SetError::BadValue { key: self.key.clone(), value: value.to_owned(), takes };
        let in_range = |v: f32| v.is_finite() && v >= min && v <= max;
        match &mut self.value {
            ParamValue::F32(target) => {
                let number = value.parse::<f32>().ok().filter(|&v| in_range(v));
                **target = number.ok_or_else(|| bad(format!("a number from {min} to {max} {}", self.unit)))?;
            }
            ParamValue::U32(target) => {
                let number = value.parse::<u32>().ok().filter(|&v| in_range(v as f32));
                **target = number.ok_or_else(|| bad(format!("a whole number from {min} to {max}")))?;
            }
            ParamValue::Colour(target) => {
                let numbers: Option<Vec<f32>> =
                    value.split(',').map(|part| part.trim().parse().ok().filter(|&v| in_range(v))).collect();
                let rgb = numbers.and_then(|numbers| <[f32; 3]>::try_from(numbers).ok());
                **target = rgb.ok_or_else(|| bad(format!("three numbers from {min} to {max}: R,G,B")))?;
            }
            ParamValue::Choice(target) => {
                let infos = target.infos();
                let index = infos.iter().position(|info| info.name == value);
                let names = || infos.iter().map(|info| info.name).collect::<Vec<_>>().join(", ");
                target.set_index(index.ok_or_else(|| bad(names()))?);
            }
        }
        Ok(())
    }
}

/// One rendering question.
pub struct Slot<'a> {
    pub key: &'static str,
    pub label: &'static str,
    pub help: &'static str,
    pub choice: &'a mut dyn AnyChoice,
    pub params: Vec<Param<'a>>,
}

impl Slot<'_> {
    /// The info of the choice made.
    pub fn chosen(&self) -> ChoiceInfo {
        self.choice.infos()[self.choice.index()]
    }
}

pub(crate) fn number<'a>(
    key: &str,
    label: &'static str,
    unit: &'static str,
    (min, max): (f32, f32),
    value: &'a mut f32,
    of: &'static [&'static str],
    help: &'static str,
) -> Param<'a> {
    Param { key: key.to_owned(), label, unit, min, max, help, of, value: ParamValue::F32(value) }
}

pub(crate) fn integer<'a>(
    key: &str,
    label: &'static str,
    unit: &'static str,
    (min, max): (u32, u32),
    value: &'a mut u32,
    of: &'static [&'static str],
    help: &'static str,
) -> Param<'a> {
    Param {
        key: key.to_owned(),
        label,
        unit,
        min: min as f32,
        max: max as f32,
        help,
        of,
        value: ParamValue::U32(value),
    }
}

pub(super) fn colour<'a>(
    key: &str,
    label: &'static str,
    value: &'a mut [f32; 3],
    of: &'static [&'static str],
    help: &'static str,
) -> Param<'a> {
    Param {
        key: key.to_owned(),
        label,
        unit: "linear RGB",
        min: 0.0,
        max: 1.0,
        help,
        of,
        value: ParamValue::Colour(value),
    }
}

pub(super) fn alternatives<'a>(
    key: &str,
    label: &'static str,
    value: &'a mut dyn AnyChoice,
    of: &'static [&'static str],
    help: &'static str,
) -> Param<'a> {
    let max = value.infos().len().saturating_sub(1) as f32;
    Param { key: key.to_owned(), label, unit: "", min: 0.0, max, help, of, value: ParamValue::Choice(value) }
}

/// Why `KEY=VALUE` was not taken.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SetError {
    #[error("there is no setting `{key}`; `lorelei looks --json` lists them all (close: {close})")]
    UnknownKey { key: String, close: String },
    #[error("`{key}` cannot be `{value}`; it takes {takes}")]
    BadValue { key: String, value: String, takes: String },
}

/// Set a slot's choice (`shadowing=off`) or a parameter (`shadowing.layers=5`) from text.
pub fn set(slots: &mut [Slot<'_>], key: &str, value: &str) -> Result<(), SetError> {
    for slot in slots.iter_mut() {
        if slot.key == key {
            let infos = slot.choice.infos();
            let index = infos.iter().position(|info| info.name == value);
            let index = index.ok_or_else(|| SetError::BadValue {
                key: key.to_owned(),
                value: value.to_owned(),
                takes: infos.iter().map(|info| info.name).collect::<Vec<_>>().join(", "),
            })?;
            slot.choice.set_index(index);
            return Ok(());
        }
        let Some(param) = slot.params.iter_mut().find(|param| param.key == key) else { continue };
        param.set_from_text(value)?;
        return Ok(());
    }
    let mut keys: Vec<String> = Vec::new();
    for slot in slots.iter() {
        keys.push(slot.key.to_owned());
        keys.extend(slot.params.iter().map(|param| param.key.clone()));
    }
    let head = key.split('.').next().unwrap_or_default();
    let close = keys.iter().filter(|k| k.starts_with(head) || k.contains(key)).cloned().collect::<Vec<_>>();
    let close = if close.is_empty() { "none".to_owned() } else { close.join(", ") };
    Err(SetError::UnknownKey { key: key.to_owned(), close })
}
