//! `--serve`: the page of `--html`, handed to a browser on this machine and to nobody else.
//!
//! The server listens on the loopback address alone. Other users of the machine can reach it there, so the page stands under a name that cannot be guessed; and a page
//! from elsewhere that the browser shows can reach it by a name of its own, so a request must name the address itself.

use super::options::ViewArgs;
use super::page;
use crate::cli::Context;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::size::bytes;
use std::hash::{BuildHasher, Hasher, RandomState};
use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use tiny_http::{Header, Method, Request, Response, Server};

pub fn run(files: &[PathBuf], port: u16, args: &ViewArgs, context: &Context) -> Result<Exit, Failure> {
    let terminal = &context.terminal;
    let (text, _) = page::text(files, args, context)?;
    let refuse = |error: String| {
        Failure::new(Exit::Io, format!("cannot listen on port {port} of this machine"))
            .fact(error)
            .help("leave out the port, and a free one is taken")
    };
    let server = Server::http((Ipv4Addr::LOCALHOST, port)).map_err(|e| refuse(e.to_string()))?;
    let address = server.server_addr().to_ip().ok_or_else(|| refuse("it has no address".into()))?;
    let place = format!("/{}/", token());
    let url = format!("http://{address}{place}");
    terminal.result(&url)?;
    terminal.note(&format!("serving {} to this machine; Ctrl-C ends it", bytes(text.len() as u64)));
    if !args.no_browser && open::that_detached(&url).is_err() {
        terminal.note("no browser could be started; open the address in one");
    }
    for request in server.incoming_requests() {
        // Whoever went away meanwhile does not want the answer.
        _ = answer(request, address, &place, &text);
    }
    Ok(Exit::Success)
}

/// A name that others cannot guess: the keys of a hash map are random.
fn token() -> String {
    let half = || RandomState::new().build_hasher().finish();
    format!("{:016x}{:016x}", half(), half())
}

fn answer(request: Request, address: SocketAddr, place: &str, text: &str) -> std::io::Result<()> {
    let of_host = |header: &&Header| header.field.equiv("Host");
    let host = request.headers().iter().find(of_host).map(|header| header.value.as_str());
    let is_here = [address.to_string(), format!("localhost:{}", address.port())].iter().any(|name| host == Some(name));
    let refuse = |code: u16| Response::from_string("").with_status_code(code);
    match (is_here, request.method(), request.url() == place) {
        (false, ..) => request.respond(refuse(403)),
        (true, Method::Get | Method::Head, true) => {
            let head = [
                "Content-Type: text/html; charset=utf-8",
                "Cache-Control: no-store",
                "X-Content-Type-Options: nosniff",
                "Referrer-Policy: no-referrer",
            ];
            // With its length, so that a browser can tell how much is left.
            let mut response = Response::from_string(text).with_chunked_threshold(usize::MAX);
            head.iter().filter_map(|line| line.parse().ok()).for_each(|header: Header| response.add_header(header));
            request.respond(response)
        }
        (true, Method::Get | Method::Head, false) => request.respond(refuse(404)),
        (true, ..) => request.respond(refuse(405)),
    }
}
