//! Mirror images: the other side of a gripper.

use schemars::JsonSchema;
use serde::Deserialize;

use super::names::{GROUND, check_name, report_name};
use crate::scene::keys::{closest_match, is_name};
use crate::scene::section_input::SectionInput;

/// Adds a mirror image, about the y axis, of everything that is called `from`, or whose name begins with `from` and an
/// underscore: bodies, joints, springs, tendons, couplings, rotors, limits, actuators, and the contacts of these bodies. The
/// names of the images contain `to` instead. Joints have the same coordinates as their images.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct MirrorSettings {
    /// Prefix of the names of the original: from = "right".
    #[schemars(extend("minLength" = 1, "x-required" = "add the beginning of the written names: from = \"right\""))]
    pub from: Option<String>,
    /// Prefix of the names of the mirror images: to = "left".
    #[schemars(extend("minLength" = 1, "x-required" = "add the beginning of the names of the images: to = \"left\""))]
    pub to: Option<String>,
}

/// Resolved `[mirror]`: the beginnings of names.
pub(super) struct Mirror {
    from: String,
    to: String,
}

impl Mirror {
    /// Name of the image of what has this name.
    fn image(&self, name: &str) -> Option<String> {
        let part = name.strip_prefix(&self.from).filter(|part| part.is_empty() || part.starts_with('_'))?;
        Some(format!("{}{part}", self.to))
    }
}

pub(super) fn mirror(section: &SectionInput<'_>) -> Option<Mirror> {
    section.is_present().then_some(())?;
    let MirrorSettings { from, to } = section.read();
    let (from, to) = (from?, to?);
    if from == to {
        let message = format!("`{}` and `to` are equal", section.path("from"));
        return section.refuse("to", message, "the same name", "name the other side: from = \"right\", to = \"left\"");
    }
    // The names of all images begin with it. They are made nevertheless: other sections refer to them.
    if !is_name(&to) {
        report_name(section, section.span("to"), ("`mirror.to`", "to = \"left\""), &to);
    }
    Some(Mirror { from, to })
}

/// Reports a mirror without images: its `from` is probably mistyped.
pub(super) fn check_images(section: &SectionInput<'_>, mirror: &Mirror, lists: &[&Entries<'_>]) {
    let written = || lists.iter().flat_map(|list| list.written()).map(|(_, name, _)| name);
    if written().any(|name| mirror.image(name).is_some()) {
        return;
    }
    let message = format!("`{}` matches no name: nothing has a mirror image", section.path("from"));
    let beginnings: Vec<&str> = written().flat_map(|name| [name, name.split('_').next().unwrap_or(name)]).collect();
    let label = closest_match(&mirror.from, &beginnings);
    let label = label.map_or("no such name".to_owned(), |near| format!("did you mean `{near}`?"));
    let help = "write the name of a body or a joint, or what comes before its first `_`: from = \"right\" stands for right, \
                right_link, …; or remove [mirror]";
    section.report("from", message, &label, help);
}

/// Entries of a list in the order of their names: its sections, and their mirror images.
pub(super) struct Entries<'a>(Vec<Entry<'a>>);

struct Entry<'a> {
    name: String,
    /// Its section, or that of the original.
    section: SectionInput<'a>,
    /// Index of the original of an image.
    original: Option<usize>,
}

impl<'a> Entries<'a> {
    /// Reads the sections in the list `key`, and adds their mirror images.
    pub fn new(root: &SectionInput<'a>, key: &str, mirror: Option<&Mirror>) -> Self {
        let sections = root.subsection(key).subsections();
        sections.iter().for_each(|(name, section)| check_name(section, key, name));
        let mut all = Vec::new();
        for (name, section) in &sections {
            let Some((from, image)) = mirror.and_then(|of| Some((&of.from, of.image(name)?))) else { continue };
            if image == GROUND {
                check_name(&root.subsection("mirror"), key, &image);
            }
            if let Some((_, written)) = sections.iter().find(|(other, _)| *other == image) {
                let message = format!("`{}` is also the mirror image of `{name}`", written.path(""));
                let help = format!("remove it, or rename `{name}`: what begins with `{from}_` has an image");
                written.report("", message, "mirrored and written", help);
            } else {
                all.push((image, section.clone(), Some(*name)));
            }
        }
        all.extend(sections.iter().map(|(name, section)| ((*name).to_owned(), section.clone(), None)));
        all.sort_by(|a, b| a.0.cmp(&b.0));
        let index_of = |name: &str| all.iter().position(|(other, ..)| other == name);
        let originals: Vec<_> = all.iter().map(|(.., original)| original.and_then(index_of)).collect();
        let entries = all.into_iter().zip(originals);
        Self(entries.map(|((name, section, _), original)| Entry { name, section, original }).collect())
    }

    pub fn names(&self) -> Vec<&str> {
        self.0.iter().map(|entry| entry.name.as_str()).collect()
    }

    /// Returns the section of an entry; for an image, that of the original.
    pub fn section(&self, index: usize) -> &SectionInput<'a> {
        &self.0[index].section
    }

    pub fn is_image(&self, index: usize) -> bool {
        self.0[index].original.is_some()
    }

    /// Entries that are written in the file, with their indices.
    pub fn written(&self) -> impl Iterator<Item = (usize, &str, &SectionInput<'a>)> {
        let written = self.0.iter().enumerate().filter(|(_, entry)| entry.original.is_none());
        written.map(|(index, entry)| (index, entry.name.as_str(), &entry.section))
    }

    /// For each entry, the index of its image; for an image, that of the original; for an entry without an image, its
    /// own.
    pub fn partners(&self) -> Vec<usize> {
        let mut partners: Vec<usize> = (0..self.0.len()).collect();
        for (image, original) in self.0.iter().enumerate().filter_map(|(image, entry)| Some((image, entry.original?))) {
            (partners[image], partners[original]) = (original, image);
        }
        partners
    }

    /// Resolves the sections of the written entries. The values of images stay `None`.
    pub fn resolve<T>(&self, resolve: impl Fn(usize, &str, &SectionInput<'a>) -> Option<T>) -> Vec<Option<T>> {
        let mut values: Vec<Option<T>> = self.0.iter().map(|_| None).collect();
        self.written().for_each(|(index, name, section)| values[index] = resolve(index, name, section));
        values
    }

    /// Adds the images of the resolved values.
    pub fn add_images<T>(&self, values: &mut [Option<T>], image: impl Fn(&T, String) -> T) {
        for (index, Entry { name, original, .. }) in self.0.iter().enumerate() {
            if let Some(original) = original {
                values[index] = values[*original].as_ref().map(|value| image(value, name.clone()));
            }
        }
    }
}
