//! WebAssembly module of the explorer: requests and responses are exchanged through buffers in its memory. It imports
//! nothing.
//!
//! A page writes a request to the buffer returned by [`allocate_request`] (exported as `alloc`) and calls [`respond`]
//! (exported as `response`). The result points to four numbers: address and byte length of the response text, address and
//! length of its numbers. All of it stays valid until the next call.

#[cfg(feature = "figures")]
mod figures;

use std::cell::RefCell;
use std::panic;
use std::sync::Once;

use phalanx_show::explorer;

/// Buffers that stay valid until the next call.
#[derive(Default)]
struct Buffers {
    request: Vec<u8>,
    response: explorer::Response,
    location: [u32; 4],
    panic_message: String,
}

thread_local! {
    static BUFFERS: RefCell<Buffers> = RefCell::default();
}

static PANIC_HOOK: Once = Once::new();

/// Allocates a buffer for a request of the given number of bytes.
#[unsafe(export_name = "alloc")]
pub extern "C" fn allocate_request(bytes: usize) -> *mut u8 {
    BUFFERS.with_borrow_mut(|buffers| {
        buffers.request = vec![0; bytes];
        buffers.request.as_mut_ptr()
    })
}

/// Processes the request of the given number of bytes.
#[unsafe(export_name = "response")]
pub extern "C" fn respond(bytes: usize) -> *const u32 {
    PANIC_HOOK.call_once(|| {
        panic::set_hook(Box::new(|panic_info| {
            let message = panic_info.to_string();
            // A trap follows: the buffers must not stay borrowed, so that the message can still be read.
            BUFFERS.with(|buffers| {
                if let Ok(mut buffers) = buffers.try_borrow_mut() {
                    buffers.panic_message = message;
                }
            });
        }));
    });
    let request = BUFFERS.with_borrow_mut(|buffers| std::mem::take(&mut buffers.request));
    let request = String::from_utf8_lossy(&request[..bytes.min(request.len())]).into_owned();
    let response = explorer::respond(&request);
    BUFFERS.with_borrow_mut(|buffers| {
        buffers.response = response;
        let Buffers { response: explorer::Response { text, data }, location, .. } = buffers;
        *location = [text.as_ptr() as u32, text.len() as u32, data.as_ptr() as u32, data.len() as u32];
        location.as_ptr()
    })
}

/// Returns the panic message of a call that ended in a trap, in the layout of a response.
#[unsafe(export_name = "error")]
pub extern "C" fn panic_message() -> *const u32 {
    BUFFERS.with_borrow_mut(|buffers| {
        buffers.location = [buffers.panic_message.as_ptr() as u32, buffers.panic_message.len() as u32, 0, 0];
        buffers.location.as_ptr()
    })
}
