//! The explorer's module: requests in, answers out, through buffers in its memory. It imports nothing.
//!
//! A page writes a request of so many bytes to where [`room`] says, and calls [`answer`]. What that points to is four numbers:
//! where the answer's text is and how many bytes it has, where its numbers are and how many. It all stands until the next call.

#[cfg(feature = "figures")]
mod figures;

use std::cell::RefCell;
use std::panic;
use std::sync::Once;

use phalanx_show::explorer;

/// What stands until the next call.
#[derive(Default)]
struct Held {
    request: Vec<u8>,
    answer: explorer::Answer,
    place: [u32; 4],
    trouble: String,
}

thread_local! {
    static HELD: RefCell<Held> = RefCell::default();
}

static HOOKED: Once = Once::new();

/// Room for a request of so many bytes.
#[unsafe(no_mangle)]
pub extern "C" fn room(bytes: usize) -> *mut u8 {
    HELD.with_borrow_mut(|held| {
        held.request = vec![0; bytes];
        held.request.as_mut_ptr()
    })
}

/// Answers the request of so many bytes.
#[unsafe(no_mangle)]
pub extern "C" fn answer(bytes: usize) -> *const u32 {
    HOOKED.call_once(|| {
        panic::set_hook(Box::new(|said| {
            let said = said.to_string();
            // A trap follows: what is held must be free for who asks after it.
            HELD.with(|held| {
                if let Ok(mut held) = held.try_borrow_mut() {
                    held.trouble = said;
                }
            });
        }));
    });
    let request = HELD.with_borrow_mut(|held| std::mem::take(&mut held.request));
    let request = String::from_utf8_lossy(&request[..bytes.min(request.len())]).into_owned();
    let found = explorer::answer(&request);
    HELD.with_borrow_mut(|held| {
        held.answer = found;
        let Held { answer: explorer::Answer { text, data }, place, .. } = held;
        *place = [text.as_ptr() as u32, text.len() as u32, data.as_ptr() as u32, data.len() as u32];
        place.as_ptr()
    })
}

/// What a call said that ended in a trap: a text, placed as an answer.
#[unsafe(no_mangle)]
pub extern "C" fn trouble() -> *const u32 {
    HELD.with_borrow_mut(|held| {
        held.place = [held.trouble.as_ptr() as u32, held.trouble.len() as u32, 0, 0];
        held.place.as_ptr()
    })
}
