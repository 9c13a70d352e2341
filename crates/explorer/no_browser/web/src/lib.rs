//! A document in which texts have about the width that plotters takes them to have where there is no document: pictures come out as
//! the program draws them.

use wasm_bindgen::JsCast;

/// Width of a letter, in heights of an em, and the em in heights of the font.
const LETTER_EM: f64 = 0.7;
const EM: f64 = 1.0 / 1.24 / 1.24;

pub struct Window;
pub struct Document;
pub struct Body;

/// A text and its size.
#[derive(Clone, Debug, Default)]
pub struct Element {
    bytes: std::cell::Cell<usize>,
    size_px: std::cell::Cell<f64>,
}

/// The same.
#[derive(Clone, Debug, Default)]
pub struct Node(Element);

/// The same.
#[derive(Clone, Debug, Default)]
pub struct HtmlElement(Element);

#[must_use]
pub fn window() -> Option<Window> {
    Some(Window)
}

impl Window {
    #[must_use]
    pub fn document(&self) -> Option<Document> {
        Some(Document)
    }
}

impl Document {
    #[must_use]
    pub fn body(&self) -> Option<Body> {
        Some(Body)
    }

    /// # Errors
    /// None.
    pub fn create_element(&self, _: &str) -> Result<Element, String> {
        Ok(Element::default())
    }
}

impl Body {
    /// # Errors
    /// None.
    pub fn append_with_node_1(&self, _: &Node) -> Result<(), String> {
        Ok(())
    }
}

impl Element {
    pub fn set_text_content(&self, text: Option<&str>) {
        self.bytes.set(text.map_or(0, str::len));
    }

    /// # Errors
    /// None.
    pub fn set_attribute(&self, _: &str, style: &str) -> Result<(), String> {
        let size = style.split("font-size:").nth(1).and_then(|rest| rest.split("px").next());
        self.size_px.set(size.and_then(|size| size.trim().parse().ok()).unwrap_or_default());
        Ok(())
    }
}

impl HtmlElement {
    #[must_use]
    pub fn offset_width(&self) -> i32 {
        (self.0.size_px.get() * EM * LETTER_EM * self.0.bytes.get() as f64).round() as i32
    }

    #[must_use]
    pub fn offset_height(&self) -> i32 {
        (self.0.size_px.get() * EM * 0.24).round() as i32
    }

    pub fn remove(&self) {}
}

impl From<Element> for Node {
    fn from(element: Element) -> Self {
        Node(element)
    }
}

impl From<Node> for HtmlElement {
    fn from(node: Node) -> Self {
        HtmlElement(node.0)
    }
}

impl JsCast for Node {}
