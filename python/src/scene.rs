//! Scenes: texts, what is set besides, and what both come to.

use std::path::{Path, PathBuf};

use phalanx::scene::{self, Layer, SceneError, Words, parse_any, parse_layers};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::{errors, words};

/// Names and contents of files.
type Texts = Vec<(String, String)>;

/// What errors call a field that is set by `with_`.
const SET: &str = "with_";

/// A scene of a finger, a gripper or discs, checked, with every default filled in. It never changes: `with_` makes another one.
#[pyclass(frozen, module = "phalanx")]
#[derive(Clone)]
pub struct Scene {
    /// The texts it is made of: those it extends, and its own.
    pub layers: Vec<Layer>,
    /// Fields set besides.
    pub settings: Vec<Layer>,
    pub scene: scene::Scene,
}

impl Scene {
    fn of(py: Python<'_>, layers: Result<Vec<Layer>, SceneError>, settings: Vec<Layer>) -> PyResult<Self> {
        let read = layers.and_then(|layers| {
            let scene = parse_layers(&layers, &settings, parse_any)?;
            Ok(Scene { layers, settings, scene })
        });
        read.map_err(|error| errors::scene(py, &error))
    }

    pub fn load_from(py: Python<'_>, path: &Path) -> PyResult<Self> {
        Scene::of(py, scene::layers(path), Vec::new())
    }

    /// What messages call its file.
    pub fn file(&self) -> &str {
        self.layers.last().map_or("", |own| own.file.as_str())
    }

    fn table<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let table: toml::Table =
            scene::show_written(&self.scene).parse().map_err(|error| errors::argument(py, error))?;
        words::json(py, &serde_json::to_string(&table).map_err(|error| errors::argument(py, error))?)
    }
}

/// A scene, or the path of its file.
#[derive(FromPyObject)]
pub enum SceneLike {
    Scene(Py<Scene>),
    Path(PathBuf),
}

impl SceneLike {
    /// The scene itself.
    pub fn get(&self, py: Python<'_>) -> PyResult<Scene> {
        match self {
            SceneLike::Scene(scene) => Ok(scene.get().clone()),
            SceneLike::Path(path) => Scene::load_from(py, path),
        }
    }
}

#[pymethods]
impl Scene {
    /// Reads a scene file (TOML), and those it extends.
    ///
    /// Raises SceneError with file, line, column and field of what is wrong.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        Scene::load_from(py, &path)
    }

    /// Reads a scene from a text (TOML). `name` is what messages and logs call its file; scenes it extends are looked for from there.
    #[staticmethod]
    #[pyo3(signature = (text, name = "scene.toml"))]
    fn from_toml(py: Python<'_>, text: &str, name: &str) -> PyResult<Self> {
        let own = Layer { file: name.to_string(), text: text.to_string() };
        Scene::of(py, scene::layers_of(own), Vec::new())
    }

    /// Reads a scene from a dictionary with the keys of a scene file: `{"design": {"base": "20 mm", …}, …}`.
    #[staticmethod]
    #[pyo3(signature = (scene, name = "scene.toml"))]
    fn from_dict(scene: &Bound<'_, PyDict>, name: &str) -> PyResult<Self> {
        Scene::from_toml(scene.py(), &words::document(scene)?, name)
    }

    /// The same scene with other values in some fields, as `phalanx run --set` has them:
    /// `scene.with_({"contact.friction.mu_static": 0.6, "design.base": "20 mm"})`.
    ///
    /// A value is a text with its unit, a number where the field is one without a unit, True or False, or a list; one element of a pair
    /// is `object.centre[0]`.
    fn with_(&self, py: Python<'_>, fields: &Bound<'_, PyDict>) -> PyResult<Self> {
        let mut settings = self.settings.clone();
        for (field, value) in fields {
            let field: String = field.extract()?;
            let set = scene::setting_of(SET, &field, &words::toml(&value)?);
            settings.push(set.map_err(|error| errors::argument(py, error))?);
        }
        Scene::of(py, Ok(self.layers.clone()), settings)
    }

    /// The scene as it was written with every default filled in, as a scene file: what `phalanx scene show` prints.
    #[getter]
    fn toml(&self) -> String {
        scene::show_written(&self.scene)
    }

    /// What is simulated, as a scene file in full precision: lengths and masses in place of a design and a material, angles of the
    /// start, the law of each contact. What `phalanx scene show --resolved` prints.
    #[getter]
    fn resolved(&self) -> String {
        scene::show(&self.scene)
    }

    /// The same as `toml`, as a dictionary of texts with units, numbers, flags and lists.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.table(py)
    }

    /// "finger", "gripper" or "bodies" (discs).
    #[getter]
    fn kind(&self) -> &'static str {
        self.scene.kind().word()
    }

    /// The name that the scene gives itself.
    #[getter]
    fn name(&self) -> &str {
        &self.scene.name
    }

    /// Length of a run, in s.
    #[getter]
    fn duration_s(&self) -> f64 {
        self.scene.duration_s
    }

    /// A field by its path, as `toml` has it: `scene["design.base"]`. Of a section, its dictionary.
    fn __getitem__<'py>(&self, py: Python<'py>, path: &str) -> PyResult<Bound<'py, PyAny>> {
        let mut here = self.table(py)?;
        for key in path.split('.') {
            let found = here.cast::<PyDict>().ok().map(|table| table.get_item(key)).transpose()?.flatten();
            here = found.ok_or_else(|| {
                PyKeyError::new_err(format!(
                    "{path}: this scene of kind \"{}\" has no such field; scene.toml shows all",
                    self.kind()
                ))
            })?;
        }
        Ok(here)
    }

    fn __repr__(&self) -> String {
        let set: Vec<&str> = self.settings.iter().map(|layer| layer.text.as_str()).collect();
        let besides = if set.is_empty() { String::new() } else { format!(", with {}", set.join(", ")) };
        let (kind, name) = (self.kind(), self.name());
        format!("<phalanx.Scene \"{name}\": {kind}, {:?} ms, from {}{besides}>", self.duration_s() * 1e3, self.file())
    }

    /// For copies in other processes.
    fn __reduce__(&self, py: Python<'_>) -> PyResult<(Py<PyAny>, (Texts, Texts))> {
        let texts = |layers: &[Layer]| layers.iter().map(|of| (of.file.clone(), of.text.clone())).collect();
        let make = py.get_type::<Scene>().getattr("_of_texts")?.unbind();
        Ok((make, (texts(&self.layers), texts(&self.settings))))
    }

    #[staticmethod]
    fn _of_texts(py: Python<'_>, layers: Texts, settings: Texts) -> PyResult<Self> {
        let of = |texts: Texts| texts.into_iter().map(|(file, text)| Layer { file, text }).collect();
        Scene::of(py, Ok(of(layers)), of(settings))
    }
}
