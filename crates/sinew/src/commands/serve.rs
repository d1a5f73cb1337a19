//! A body, or stored runs, for samplers and other programs, over HTTP.

mod http;

use super::stop::signalled;
use super::{CaseArguments, Usage, chosen, refuse, runs, trained};
use anyhow::Result;
use clap::Args;
use http::Connection;
use sinew::PatientFile;
use sinew::serve::{Response, Service};
use std::fmt::Display;
use std::io::{self, ErrorKind};
use std::net::{IpAddr, TcpListener, ToSocketAddrs};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::Ordering;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

/// Time between two looks whether the server is to end, and after a client that could not be taken.
const PAUSE: Duration = Duration::from_millis(20);
/// Time for requests that are on their way when the server ends.
const GRACE: Duration = Duration::from_millis(500);

/// Body and address.
#[derive(Debug, Args)]
#[command(after_help = include_str!("help/serve.txt"))]
pub(crate) struct Serve {
    #[command(flatten)]
    case: CaseArguments,
    /// Port; 0 takes one that is free
    #[arg(long, default_value_t = 4242)]
    port: u16,
    /// Address to listen at; any address but the loopback is open to all who reach it
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1", value_parser = address)]
    bind: IpAddr,
    /// Name of the emulator's folder within OUT [default: the only one, or that of the case's recipe]
    #[arg(long, value_name = "NAME")]
    emulator: Option<String>,
    /// Requests that are answered at the same time [default: the processor's cores]
    #[arg(long, value_name = "COUNT")]
    threads: Option<usize>,
    /// Seconds that a request may take to arrive
    #[arg(long, value_name = "SECONDS", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..))]
    timeout: u64,
}

/// Address by its numbers or its name.
fn address(text: &str) -> Result<IpAddr, String> {
    let found: Vec<IpAddr> =
        (text, 0).to_socket_addrs().into_iter().flatten().map(|it| it.ip()).collect();
    let chosen = found.iter().find(|address| address.is_ipv4()).or(found.first());
    chosen
        .copied()
        .ok_or_else(|| "no machine has this name; give an address such as 127.0.0.1".into())
}

impl Serve {
    pub(crate) fn run(&self) -> Result<()> {
        if let Some(runs) = runs::trained(&self.case, [self.emulator.is_some()], "--emulator")? {
            return self.serve(&Service::of_runs(&runs), &self.case.file.case.display());
        }
        let (case, body, folder) = self.case.open()?;
        let file = PatientFile::of(case)?;
        let unfit = |why: &_| eprintln!("warning: {why}; the model patient is not served");
        let prepared = file.has_data().then(|| file.prepare().inspect_err(unfit).ok()).flatten();
        let emulator = match (&self.emulator, trained(&folder)) {
            (None, Err(none)) if none.is::<Usage>() => {
                eprintln!("{none}; the solver alone is served");
                None
            }
            _ => {
                let (_, path) = chosen(self.emulator.as_deref(), &file.case, &folder)?;
                Some(sinew::load(&path, &body)?)
            }
        };
        let mut service = Service::new(&body, emulator);
        if let Some(prepared) = &prepared {
            service = service.with_patient(prepared).map_err(Usage)?;
        }
        // The page is for this machine alone.
        if self.bind.is_loopback() {
            service = service.with_page(sinew::PAGE_SEED);
        }
        self.serve(&service, &body.name)
    }

    fn serve(&self, service: &Service<'_>, name: &dyn Display) -> Result<()> {
        let listener = TcpListener::bind((self.bind, self.port));
        let listener = listener.or_else(|error| refuse(self.not_bound(&error)))?;
        let address = listener.local_addr()?;
        let models = service.models();
        println!("models: {}", models.join(", "));
        let of_patient = models.contains(&"patient").then_some(("patient", " of patient"));
        for (model, of) in [(models[0], "")].into_iter().chain(of_patient) {
            let [input, output] = service.heads(model).map(|heads| heads.join(", "));
            println!("input{of}: {input}\noutput{of}: {output}");
        }
        if service.has_page() {
            println!("page: http://{address}/, made when it is opened first");
        }
        println!("serving {name} at http://{address}");
        let cores = thread::available_parallelism().map_or(1, usize::from);
        let free = self.threads.unwrap_or(cores).max(1);
        let state = Mutex::new(State { free, open: 0, ending: false });
        self.listen(&listener, service, &Desk { state, changed: Condvar::new() })
    }

    /// Takes clients until a signal comes, and ends the program when requests under way are answered.
    fn listen(&self, listener: &TcpListener, service: &Service<'_>, desk: &Desk) -> Result<()> {
        let (stop, limit) = (signalled()?, Duration::from_secs(self.timeout));
        thread::scope(|scope| {
            scope.spawn(move || {
                loop {
                    let taken = listener.accept().and_then(|(stream, _)| {
                        let client = move || answer(service, desk, Connection::new(stream, limit));
                        thread::Builder::new().spawn_scoped(scope, client)
                    });
                    // There are too many clients, until some leave.
                    if taken.is_err() {
                        thread::sleep(PAUSE);
                    }
                }
            });
            while !stop.load(Ordering::Relaxed) {
                thread::sleep(PAUSE);
            }
            eprintln!("ending: requests under way are answered; a second signal ends at once");
            desk.end();
            std::process::exit(0)
        })
    }

    fn not_bound(&self, error: &io::Error) -> String {
        let advice = match error.kind() {
            ErrorKind::AddrNotAvailable => {
                "this machine has no such address; choose another --bind"
            }
            ErrorKind::AddrInUse => "another program listens there; choose another --port",
            ErrorKind::PermissionDenied => "this port is not yours; choose one above 1023",
            _ => "choose another --bind or --port",
        };
        format!("--bind {} --port {}: {error}: {advice}", self.bind, self.port)
    }
}

/// Turns of requests: as many compute at a time as there are threads.
struct Desk {
    state: Mutex<State>,
    changed: Condvar,
}

struct State {
    free: usize,
    /// Requests that have arrived and are not answered.
    open: usize,
    ending: bool,
}

impl Desk {
    fn change(&self, change: impl FnOnce(&mut State)) {
        change(&mut self.state.lock().unwrap_or_else(PoisonError::into_inner));
        self.changed.notify_all();
    }

    fn wait(&self, busy: impl FnMut(&mut State) -> bool) -> MutexGuard<'_, State> {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        self.changed.wait_while(state, busy).unwrap_or_else(PoisonError::into_inner)
    }

    /// The answer, once there is a turn; a refusal when the server ends before.
    fn answer(&self, compute: impl FnOnce() -> Response) -> Response {
        let mut state = self.wait(|state| state.free == 0 && !state.ending);
        if state.ending {
            let reason = "the server is ending; send the request again once it is back";
            return Response::failed(503, "Unavailable", reason);
        }
        state.free -= 1;
        drop(state);
        // A panic ends one request, not the server.
        let reply = catch_unwind(AssertUnwindSafe(compute)).unwrap_or_else(|_| {
            Response::failed(500, "InternalError", "the program failed; its terminal says where")
        });
        self.change(|state| state.free += 1);
        reply
    }

    /// Begins no more, and waits until all that has arrived is answered.
    fn end(&self) {
        self.change(|state| state.ending = true);
        drop(self.wait(|state| state.open > 0));
        // A client that is connected and not yet read is refused too, not cut off.
        thread::sleep(GRACE);
        drop(self.wait(|state| state.open > 0));
    }
}

/// Answers a client's requests until it leaves.
fn answer(service: &Service<'_>, desk: &Desk, mut client: Connection) {
    let mut goes_on = true;
    while goes_on {
        let request = match client.request() {
            Ok(request) => request,
            Err(None) => return,
            Err(Some(refused)) => {
                client.answer(&refused, false, true);
                return;
            }
        };
        desk.change(|state| state.open += 1);
        let is_head = request.method == "HEAD";
        let method = if is_head { "GET" } else { &request.method };
        let reply = desk.answer(|| service.answer(method, &request.path, &request.content));
        goes_on = client.answer(&reply, is_head, request.last);
        desk.change(|state| state.open -= 1);
    }
}
