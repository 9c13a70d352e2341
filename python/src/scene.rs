//! The class `Scene`: scene files as text layers, field settings, and the resulting validated scene.

use std::path::{Path, PathBuf};

use phalanx::mjcf::mujoco_model;
use phalanx::scene::{self, Keyword, Layer, SceneError, parse_layers};
use phalanx::trace::Model;
use phalanx::trace::overrides::Overrides;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyMapping};

use super::{conversion, errors, quantities};

/// Names and contents of files.
type NamedTexts = Vec<(String, String)>;

/// File name in error messages about a field that `with_` sets.
const SETTING_FILE: &str = "with_";

/// A validated scene of a finger, a gripper, a mechanism or discs. It is immutable: `with_` returns a changed copy.
#[pyclass(frozen, module = "phalanx")]
#[derive(Clone)]
pub struct Scene {
    /// The text of the scene, preceded by the texts of the scenes that it extends.
    pub layers: Vec<Layer>,
    /// Fields set by `with_`.
    pub settings: Vec<Layer>,
    pub scene: scene::Scene,
}

impl Scene {
    pub fn from_layers(py: Python<'_>, layers: Result<Vec<Layer>, SceneError>, settings: Vec<Layer>) -> PyResult<Self> {
        let scene = layers.and_then(|layers| {
            let scene = parse_layers(&layers, &settings)?;
            Ok(Scene { layers, settings, scene })
        });
        scene.map_err(|error| errors::scene(py, &error))
    }

    pub fn load_from(py: Python<'_>, path: &Path) -> PyResult<Self> {
        Scene::from_layers(py, scene::load_layers(path), Vec::new())
    }

    /// Returns a copy whose integrator has the settings of a preset; an unchanged copy if `name` is `None`.
    pub fn with_preset(&self, py: Python<'_>, model: Model, name: Option<&str>) -> PyResult<Self> {
        let Some(preset) = super::simulate::parse_preset(py, name)? else { return Ok(self.clone()) };
        let mut scene = self.scene.clone();
        let overrides = Overrides { preset: Some(preset), ..Overrides::default() };
        overrides.apply(model, &mut scene).map_err(|error| errors::argument(py, error))?;
        let scene::Integrator { method, rtol, atol_angle_rad, atol_rate_rad_s, .. } = scene.integrator;
        let texts = [
            ("preset", format!("\"{}\"", preset.keyword())),
            ("method", format!("\"{}\"", method.keyword())),
            ("rtol", format!("{rtol:?}")),
            ("atol_angle", format!("\"{atol_angle_rad:?} rad\"")),
            ("atol_rate", format!("\"{atol_rate_rad_s:?} rad/s\"")),
        ];
        let mut settings = self.settings.clone();
        for (key, text) in texts {
            let setting = scene::setting_from_parts(SETTING_FILE, &format!("integrator.{key}"), &text);
            settings.push(setting.map_err(|error| errors::argument(py, error))?);
        }
        Scene::from_layers(py, Ok(self.layers.clone()), settings)
    }

    /// Name of the file, for messages.
    pub fn file(&self) -> &str {
        self.layers.last().map_or("", |layer| layer.file.as_str())
    }

    fn to_python_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let text = scene::show_written(&self.scene);
        let table = scene::parse::values(&text).map_err(|error| errors::argument(py, error))?;
        conversion::parse_unchanged_json(
            py,
            &serde_json::to_string(&table).map_err(|error| errors::argument(py, error))?,
        )
    }
}

/// A scene, or the path of its file.
#[derive(FromPyObject)]
pub enum SceneLike {
    Scene(Py<Scene>),
    Path(PathBuf),
}

impl SceneLike {
    /// Returns the scene; loads it if this is a path.
    pub fn get(&self, py: Python<'_>) -> PyResult<Scene> {
        match self {
            SceneLike::Scene(scene) => Ok(scene.get().clone()),
            SceneLike::Path(path) => Scene::load_from(py, path),
        }
    }

    /// Returns the scene as an object of Python; loads it if this is a path.
    pub fn into_python(self, py: Python<'_>) -> PyResult<Py<Scene>> {
        match self {
            SceneLike::Scene(scene) => Ok(scene),
            SceneLike::Path(path) => Py::new(py, Scene::load_from(py, &path)?),
        }
    }
}

#[pymethods]
impl Scene {
    /// Reads a scene file (TOML) and the files that it extends.
    ///
    /// Raises SceneError with file, line, column and field of the error.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        Scene::load_from(py, &path)
    }

    /// Reads a scene from a TOML string. `name` is its file name in messages and logs; extended scenes are relative to
    /// its directory.
    #[staticmethod]
    #[pyo3(signature = (text, name = "scene.toml"))]
    fn from_toml(py: Python<'_>, text: &str, name: &str) -> PyResult<Self> {
        let layer = Layer { file: name.to_string(), text: text.to_string() };
        Scene::from_layers(py, scene::load_extended(layer), Vec::new())
    }

    /// Reads a scene from a dictionary with the keys of a scene file: `{"design": {"base": "20 mm", …}, …}`.
    /// Quantities are strings with units, or numbers in SI.
    #[staticmethod]
    #[pyo3(signature = (scene, name = "scene.toml"))]
    fn from_dict(scene: &Bound<'_, PyDict>, name: &str) -> PyResult<Self> {
        Scene::from_toml(scene.py(), &conversion::scene_text(scene, name)?, name)
    }

    /// Returns a copy with other values of some fields, as with `phalanx run --set`:
    /// `scene.with_({"contact.friction.mu_static": 0.6, "design.base": "20 mm"})`.
    ///
    /// A value is a string with a unit, a number (in SI, if the field has a unit), True or False, or a list.
    /// `object.centre[0]` is an entry of a list. A string that begins with "=" is an expression.
    fn with_(&self, py: Python<'_>, fields: &Bound<'_, PyMapping>) -> PyResult<Self> {
        let mut settings = self.settings.clone();
        for item in fields.items()? {
            let (field, value): (String, Bound<'_, PyAny>) = item.extract()?;
            let text = quantities::setting_text(self, &field, &value)?;
            let setting = scene::setting_from_parts(SETTING_FILE, &field, &text);
            settings.push(setting.map_err(|error| errors::argument(py, error))?);
        }
        Scene::from_layers(py, Ok(self.layers.clone()), settings)
    }

    /// The scene as written, with all defaults, as the text of a scene file: the output of `phalanx scene show`.
    #[getter]
    fn toml(&self) -> String {
        scene::show_written(&self.scene)
    }

    /// The simulated scene as the text of a scene file in full precision, with lengths and masses in place of a design
    /// and a material, initial angles, and the law of each contact: the output of `phalanx scene show --resolved`.
    #[getter]
    fn resolved(&self) -> String {
        scene::show(&self.scene)
    }

    /// Returns the contents of `toml` as a dictionary of strings with units, numbers, flags and lists.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.to_python_dict(py)
    }

    /// Returns the MuJoCo model of the scene (`phalanx scene export`). Contacts, limits and friction are MuJoCo's own.
    ///
    /// Raises SceneError for a scene that has no model in MuJoCo.
    fn to_mjcf(&self, py: Python<'_>) -> PyResult<String> {
        let argument_error = |message: String| errors::argument(py, format!("{}: {message}", self.file()));
        let mechanism = self.scene.mechanism().map_err(|error| argument_error(error.to_string()))?;
        let model = mujoco_model(self.name(), &mechanism, self.scene.duration_s);
        Ok(model.map_err(|error| argument_error(error.to_string()))?.xml)
    }

    /// "finger", "gripper", "bodies" (discs) or "mechanism".
    #[getter]
    fn kind(&self) -> &'static str {
        self.scene.kind.keyword()
    }

    /// The field `name` of the scene.
    #[getter]
    fn name(&self) -> &str {
        &self.scene.name
    }

    /// Duration of a run, s.
    #[getter]
    fn duration_s(&self) -> f64 {
        self.scene.duration_s
    }

    /// Returns a field of `toml` by its path, such as `scene["design.base"]` or `scene["gravity[1]"]`, or a section as a
    /// dictionary.
    fn __getitem__<'py>(&self, py: Python<'py>, path: &str) -> PyResult<Bound<'py, PyAny>> {
        let mut value = self.to_python_dict(py)?;
        for part in scene::parse_field(path).map_err(PyKeyError::new_err)? {
            let get = |key: &str| {
                Ok::<_, PyErr>(value.cast::<PyDict>().ok().map(|table| table.get_item(key)).transpose()?.flatten())
            };
            // An entry without its list is a key of its own.
            if let Some(entry) = get(&part.key())? {
                value = entry;
                continue;
            }
            value = get(&part.name)?.ok_or_else(|| {
                PyKeyError::new_err(format!(
                    "{path} is not a field of this scene of kind \"{}\"; scene.toml shows all fields",
                    self.kind()
                ))
            })?;
            for entry in part.entries {
                let count = value.cast::<PyList>().map_or(0, |list| list.len());
                if entry >= count {
                    return Err(PyKeyError::new_err(scene::no_such_entry(&part.name, entry, count)));
                }
                value = value.get_item(entry)?;
            }
        }
        Ok(value)
    }

    fn __repr__(&self) -> String {
        let settings: Vec<&str> = self.settings.iter().map(|layer| layer.text.as_str()).collect();
        let suffix = if settings.is_empty() { String::new() } else { format!(", with {}", settings.join(", ")) };
        let (kind, name) = (self.kind(), self.name());
        format!("<phalanx.Scene \"{name}\": {kind}, {:?} ms, from {}{suffix}>", self.duration_s() * 1e3, self.file())
    }

    /// Supports pickling, such as for other processes.
    fn __reduce__(&self, py: Python<'_>) -> PyResult<(Py<PyAny>, (NamedTexts, NamedTexts))> {
        let to_texts = |layers: &[Layer]| layers.iter().map(|layer| (layer.file.clone(), layer.text.clone())).collect();
        let constructor = py.get_type::<Scene>().getattr("_from_texts")?.unbind();
        Ok((constructor, (to_texts(&self.layers), to_texts(&self.settings))))
    }

    #[staticmethod]
    fn _from_texts(py: Python<'_>, layers: NamedTexts, settings: NamedTexts) -> PyResult<Self> {
        let to_layers = |texts: NamedTexts| texts.into_iter().map(|(file, text)| Layer { file, text }).collect();
        Scene::from_layers(py, Ok(to_layers(layers)), to_layers(settings))
    }
}
