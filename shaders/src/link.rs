//! One WGSL file and everything it imports, made into one naga module.
//!
//! naga_oil composes; this file finds the imports that are needed, puts the chosen file in every slot, gives back
//! names without naga_oil's decoration, and turns its errors into file, line and message.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;

use naga::valid::Capabilities;
use naga_oil::compose::{
    ComposableModuleDescriptor, Composer, ComposerError, NagaModuleDescriptor, ShaderDefValue, get_preprocessor_data,
};

use crate::error::ShaderError;
use crate::library::Link;

pub(crate) type Sources = BTreeMap<String, Arc<str>>;

/// Prefix of every import path of ours.
const PREFIX: &str = "lorelei::";

/// A linked module, valid, with all of its entry points.
pub(crate) struct Linked {
    pub file: String,
    pub module: naga::Module,
}

/// What a shader may use at all; whether a device has it is found when the pipeline is made.
pub(crate) fn capabilities() -> Capabilities {
    wgpu_naga_bridge::features_to_naga_capabilities(
        wgpu::Features::SHADER_INT64
            | wgpu::Features::SHADER_INT64_ATOMIC_MIN_MAX
            | wgpu::Features::SHADER_INT64_ATOMIC_ALL_OPS
            | wgpu::Features::SUBGROUP
            | wgpu::Features::FLOAT32_FILTERABLE,
        wgpu::DownlevelFlags::all(),
    )
}

pub(crate) fn link(sources: &Sources, file: &str, links: &[Link<'_>]) -> Result<Linked, ShaderError> {
    let source = sources.get(file).ok_or_else(|| ShaderError::NoFile { file: file.to_owned() })?;
    let mut slots: HashMap<&str, &str> = HashMap::new();
    let mut defs: HashMap<String, ShaderDefValue> = HashMap::new();
    for &link in links {
        match link {
            Link::Slot(slot, stem) => {
                slots.insert(slot, stem);
            }
            Link::Def(name) => {
                defs.insert(name.to_owned(), ShaderDefValue::Bool(true));
            }
            Link::DefU32(name, value) => {
                defs.insert(name.to_owned(), ShaderDefValue::UInt(value));
            }
        }
    }

    let mut composer = Composer::default().with_capabilities(capabilities());
    let mut order = Vec::new();
    visit_imports(sources, &slots, file, &mut order, &mut BTreeSet::new())?;
    for (import, stem) in &order {
        composer
            .add_composable_module(ComposableModuleDescriptor {
                source: &sources[stem],
                file_path: stem,
                as_name: Some(import.clone()),
                shader_defs: HashMap::new(),
                ..ComposableModuleDescriptor::default()
            })
            .map(|_| ())
            .map_err(|error| source_error(&composer, stem, &error))?;
    }
    let mut module = composer
        .make_naga_module(NagaModuleDescriptor {
            source,
            file_path: file,
            shader_defs: defs,
            ..NagaModuleDescriptor::default()
        })
        .map_err(|error| source_error(&composer, file, &error))?;
    undecorate(&mut module);
    Ok(Linked { file: file.to_owned(), module })
}

/// The import paths that a file names, once each, as (path, offset-free) strings.
fn imports_of(source: &str) -> BTreeSet<String> {
    let (_, imports, _) = get_preprocessor_data(source);
    imports.into_iter().map(|definition| definition.import).collect()
}

/// The stem of the file that an import path means.
fn stem_of<'a>(sources: &Sources, slots: &HashMap<&str, &'a str>, import: &'a str) -> Option<&'a str> {
    let name = import.strip_prefix(PREFIX)?;
    let stem = slots.get(name).copied().unwrap_or(name);
    sources.contains_key(stem).then_some(stem)
}

/// Depth first, so that every import comes before whoever needs it.
fn visit_imports(
    sources: &Sources,
    slots: &HashMap<&str, &str>,
    file: &str,
    order: &mut Vec<(String, String)>,
    seen: &mut BTreeSet<String>,
) -> Result<(), ShaderError> {
    for import in imports_of(&sources[file]) {
        // `#import lorelei::a::item` without braces names the item too: the longest path that is a file wins.
        let mut path = import.as_str();
        let stem = loop {
            if let Some(stem) = stem_of(sources, slots, path) {
                break stem.to_owned();
            }
            match path.rsplit_once("::") {
                Some((shorter, _)) => path = shorter,
                None => {
                    return Err(ShaderError::NoImport { file: file.to_owned(), import: import.clone() });
                }
            }
        };
        if seen.insert(path.to_owned()) {
            visit_imports(sources, slots, &stem, order, seen)?;
            order.push((path.to_owned(), stem));
        }
    }
    Ok(())
}

/// The imports of a file, through all files, that no file defines.
pub(crate) fn slots_of(sources: &Sources, file: &str) -> Result<Vec<String>, ShaderError> {
    let mut open = vec![file.to_owned()];
    let mut seen = BTreeSet::new();
    let mut slots = BTreeSet::new();
    while let Some(file) = open.pop() {
        let source = sources.get(&file).ok_or_else(|| ShaderError::NoFile { file: file.clone() })?;
        for import in imports_of(source) {
            let Some(path) = import.strip_prefix(PREFIX) else { continue };
            let name = path.split("::").next().unwrap_or(path);
            if !sources.contains_key(name) {
                if slots.insert(name.to_owned()) {
                    // What may stand in for it may have slots of its own.
                    open.extend(files_for_slot(sources, name));
                }
            } else if seen.insert(name.to_owned()) {
                open.push(name.to_owned());
            }
        }
    }
    Ok(slots.into_iter().collect())
}

/// Stems of the files that say `// slot: NAME`.
pub(crate) fn files_for_slot(sources: &Sources, slot: &str) -> Vec<String> {
    let mark = format!("// slot: {slot}");
    let fits = |text: &str| text.lines().any(|line| line.trim_end() == mark);
    sources.iter().filter(|(_, text)| fits(text)).map(|(stem, _)| stem.clone()).collect()
}

/// naga_oil writes `item` of an imported module as `itemX_naga_oil_mod_X...X`. Bindings, overrides and whoever reads
/// the generated code want `item`; the WGSL writer keeps equal names apart by itself.
fn undecorate(module: &mut naga::Module) {
    let strip = |name: &mut Option<String>| {
        if let Some(at) = name.as_ref().and_then(|name| name.find("X_naga_oil_mod_X")) {
            name.as_mut().expect("it was there one line above").truncate(at);
        }
    };
    for (_, variable) in module.global_variables.iter_mut() {
        strip(&mut variable.name);
    }
    for (_, constant) in module.overrides.iter_mut() {
        strip(&mut constant.name);
    }
    for (_, constant) in module.constants.iter_mut() {
        strip(&mut constant.name);
    }
    for (_, function) in module.functions.iter_mut() {
        strip(&mut function.name);
    }
}

/// naga_oil's report is a drawing for a terminal; its first place is what a person jumps to.
fn source_error(composer: &Composer, file: &str, error: &ComposerError) -> ShaderError {
    let report = without_colours(&error.emit_to_string(composer));
    let place = report.lines().find_map(|line| line.trim_start().strip_prefix("┌─ "));
    let mut parts = place.unwrap_or(file).rsplitn(3, ':');
    let (_column, line, path) = (parts.next(), parts.next(), parts.next());
    let message = report.lines().filter(|line| !line.trim_start().starts_with("┌─")).collect::<Vec<_>>().join("\n");
    ShaderError::Source {
        file: path.unwrap_or(file).to_owned(),
        line: line.and_then(|line| line.parse().ok()).unwrap_or(0),
        message: message.trim().to_owned(),
    }
}

/// Text without ANSI escapes (`ESC [ .. letter`).
fn without_colours(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    let mut characters = text.chars();
    while let Some(character) = characters.next() {
        if character == '\u{1b}' {
            characters.by_ref().find(char::is_ascii_alphabetic);
        } else {
            plain.push(character);
        }
    }
    plain
}
