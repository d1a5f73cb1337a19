//! A body for samplers and other programs, over HTTP.

use super::{CaseArguments, Usage, chosen, refuse, trained};
use anyhow::Result;
use clap::Args;
use sinew::serve::{self, Service};
use std::io::Read;
use std::net::IpAddr;
use std::panic::{AssertUnwindSafe, catch_unwind};
use tiny_http::{Header, Request, Response, Server};

/// Largest request that is read \[bytes\].
const MOST_BYTES: u64 = 1 << 20;

/// Body and address.
#[derive(Debug, Args)]
#[command(after_help = "\
Speaks UM-Bridge 1.0, whose clients exist in Python, R, Julia, MATLAB and C++. Models: emulator (a prediction), corrected (a
prediction and one Newton step), solver (the equilibrium). The input is theta in the units of the case file; the output is
one vector, whose entries are printed at the start. Evaluate, Gradient and ApplyJacobian are supported. Outside the ranges of
the parameters, emulator and corrected answer InvalidInput unless the request's config has \"extrapolate\": true. Without a
trained emulator there is the solver alone. Ends with Ctrl-C.

A browser shows the emulator's page at the same address. Where the sliders rest, the solver corrects the body, and the true
error stands beside the estimated one. With another address than the loopback there is no page.

Example: sinew train IdealVentricle --recipe regression && sinew serve IdealVentricle
  python: umbridge.HTTPModel('http://127.0.0.1:4242', 'emulator')([[0.2, 2.0, 3.0, 2.0, 8.0]])")]
pub(crate) struct Serve {
    #[command(flatten)]
    case: CaseArguments,
    /// Port; 0 takes one that is free
    #[arg(long, default_value_t = 4242)]
    port: u16,
    /// Address to listen at; any address but the loopback is open to all who reach it
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1")]
    bind: IpAddr,
    /// Name of the emulator's folder within OUT [default: the only one, or that of the case's recipe]
    #[arg(long, value_name = "NAME")]
    emulator: Option<String>,
    /// Requests that are answered at the same time [default: the processor's cores]
    #[arg(long, value_name = "COUNT")]
    threads: Option<usize>,
}

impl Serve {
    pub(crate) fn run(&self) -> Result<()> {
        let (case, body, folder) = self.case.open()?;
        let emulator = match (&self.emulator, trained(&folder)) {
            (None, Err(none)) if none.is::<Usage>() => {
                eprintln!("{none}; the solver alone is served");
                None
            }
            _ => {
                let (_, path) = chosen(self.emulator.as_deref(), &case, &folder)?;
                Some(sinew::load(&path, &body)?)
            }
        };
        let service = Service::new(&body, emulator);
        // The page is for this machine alone.
        let service = match self.bind.is_loopback() {
            true => service.with_page(super::export::SEED),
            false => service,
        };
        let server = match Server::http((self.bind, self.port)) {
            Ok(server) => server,
            Err(error) => {
                return refuse(format!(
                    "--bind {} --port {}: {error}; choose another port",
                    self.bind, self.port
                ));
            }
        };
        let parameters: Vec<_> =
            body.parameters.iter().map(|parameter| parameter.unit.head(&parameter.name)).collect();
        println!("models: {}", service.models().join(", "));
        println!("input: {}", parameters.join(", "));
        println!("output: {}", service.outputs().join(", "));
        if service.has_page() {
            println!("page: http://{}/, made when it is opened first", server.server_addr());
        }
        println!("serving {} at http://{}", body.name, server.server_addr());
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        std::thread::scope(|scope| {
            for _ in 0..self.threads.unwrap_or(cores).max(1) {
                scope.spawn(|| {
                    while let Ok(request) = server.recv() {
                        answer(&service, request);
                    }
                });
            }
        });
        Ok(())
    }
}

/// Answers one request, unless the client has left.
fn answer(service: &Service<'_>, mut request: Request) {
    let (method, url) = (request.method().to_string(), request.url().to_string());
    let path = url.split('?').next().unwrap_or_default();
    let reply = match content(&mut request) {
        Err(refused) => refused,
        // A panic ends one request, not the server.
        Ok(text) => catch_unwind(AssertUnwindSafe(|| service.answer(&method, path, &text)))
            .unwrap_or_else(|_| {
                failed(500, "InternalError", "the program failed; its terminal says where".into())
            }),
    };
    let header = Header::from_bytes("Content-Type", reply.kind);
    let mut response = Response::from_string(reply.text).with_status_code(reply.status);
    if let Ok(header) = header {
        response.add_header(header);
    }
    let _ = request.respond(response);
}

/// Content of a request.
fn content(request: &mut Request) -> Result<String, serve::Response> {
    let refused = |reason: String| failed(400, "InvalidInput", reason);
    let mut bytes = Vec::new();
    let read = request.as_reader().take(MOST_BYTES + 1).read_to_end(&mut bytes);
    read.map_err(|error| refused(format!("the request cannot be read: {error}; send it again")))?;
    if bytes.len() as u64 > MOST_BYTES {
        let reason = format!("the request is longer than {MOST_BYTES} bytes; send shorter ones");
        return Err(failed(413, "InvalidInput", reason));
    }
    String::from_utf8(bytes)
        .map_err(|error| refused(format!("the request is not UTF-8: {error}; send JSON")))
}

/// Error of the protocol.
fn failed(status: u16, kind: &str, message: String) -> serve::Response {
    serve::Response {
        status,
        kind: "application/json",
        text: serde_json::json!({ "error": { "type": kind, "message": message } }).to_string(),
    }
}
