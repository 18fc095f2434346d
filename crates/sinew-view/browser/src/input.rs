//! Keys and pointer, as a person uses them.

use crate::Outcome;
use crate::browser::Browser;
use fantoccini::actions::{InputSource, KeyAction, KeyActions, MouseActions, PointerAction};
use std::time::Duration;

/// Presses a key and lets it go.
pub(crate) async fn key(page: &Browser, value: char) -> Outcome<()> {
    let keys =
        KeyActions::new("keyboard".to_owned()).then(KeyAction::Down { value }).then(KeyAction::Up { value });
    page.client.perform_actions(keys).await.map_err(|e| format!("key {value:?}: {e}"))
}

/// Drags from one place of the page to another, in steps, and holds there before letting go.
pub(crate) async fn drag(page: &Browser, from: [f64; 2], by: [f64; 2], hold: Duration) -> Outcome<()> {
    let to = |fraction: f64, milliseconds: u64| PointerAction::MoveTo {
        duration: Some(Duration::from_millis(milliseconds)),
        x: from[0] + fraction * by[0],
        y: from[1] + fraction * by[1],
    };
    let mut mouse =
        MouseActions::new("mouse".to_owned()).then(to(0.0, 0)).then(PointerAction::Down { button: 0 });
    for k in 1..=10 {
        mouse = mouse.then(to(f64::from(k) / 10.0, 40));
    }
    let mouse = mouse.then(PointerAction::Pause { duration: hold }).then(PointerAction::Up { button: 0 });
    page.client.perform_actions(mouse).await.map_err(|e| format!("drag: {e}"))
}

/// Clicks the element that a selector finds.
pub(crate) async fn click(page: &Browser, selector: &str) -> Outcome<()> {
    let found =
        page.client.find(fantoccini::Locator::Css(selector)).await.map_err(|e| format!("{selector}: {e}"))?;
    found.click().await.map_err(|e| format!("{selector}: {e}"))
}
