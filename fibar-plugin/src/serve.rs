//! The main function of every plugin: the protocol on stdio, one run by hand, or help.

use crate::line::Line;
use crate::stage::{Stage, full_description};
use crate::{Job, StageError, help};
use fibar_core::protocol::{
    FailureKind, Hello, HostMessage, PROTOCOL_VERSION, PluginMessage, Request, STDIO_FLAG,
};
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;

/// Exit code for arguments and requests that cannot be understood.
const BAD_USAGE: u8 = 2;
/// Exit code for a stage that is itself at fault, or a host that breaks the protocol.
const FAULT: u8 = 5;

/// Runs the plugin as its arguments say; call it from `main`.
pub fn serve<S: Stage>() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let description = full_description::<S>();
    match arguments.as_slice() {
        [STDIO_FLAG] => serve_stdio::<S>(),
        ["--request", file] => run_by_hand::<S>(file),
        ["--describe"] => print_lines(&serde_json::to_string_pretty(&description).expect("plain data")),
        ["--version"] => print_lines(&format!("{} {}", description.name, description.version)),
        ["--help" | "-h"] | [] => print_lines(&help::text(&description)),
        _ => {
            eprintln!("{}: cannot understand {arguments:?}; try --help", description.name);
            ExitCode::from(BAD_USAGE)
        }
    }
}

/// Prints; a reader that has seen enough, such as `head`, is no failure.
fn print_lines(text: &str) -> ExitCode {
    let _ = writeln!(std::io::stdout(), "{text}");
    ExitCode::SUCCESS
}

/// Speaks the protocol: hello, then one `describe` or `run`.
fn serve_stdio<S: Stage>() -> ExitCode {
    let line = match take_stdout() {
        Ok(out) => Line::new(out),
        Err(e) => return fault(&format!("cannot set up standard output: {e}")),
    };
    let description = full_description::<S>();
    line.send(&PluginMessage::Hello(Hello::new(format!("{} {}", description.name, description.version))));
    let mut input = BufReader::new(std::io::stdin());
    match next_message(&mut input) {
        Ok(HostMessage::Hello(hello)) if hello.protocol == PROTOCOL_VERSION => {}
        Ok(HostMessage::Hello(hello)) => {
            return fault(&format!("speaks protocol {PROTOCOL_VERSION}, the host {}", hello.protocol));
        }
        other => return fault(&format!("expected hello, got {other:?}")),
    }
    match next_message(&mut input) {
        Ok(HostMessage::Describe {}) => {
            line.send(&PluginMessage::Description(Box::new(description)));
            ExitCode::SUCCESS
        }
        Ok(HostMessage::Run(request)) => {
            line.clone().listen(input);
            run_and_report::<S>(request, &line)
        }
        other => fault(&format!("expected describe or run, got {other:?}")),
    }
}

fn fault(message: &str) -> ExitCode {
    eprintln!("{message}");
    ExitCode::from(FAULT)
}

fn next_message(input: &mut impl BufRead) -> Result<HostMessage, String> {
    let mut text = String::new();
    input.read_line(&mut text).map_err(|e| e.to_string())?;
    serde_json::from_str(&text).map_err(|e| format!("{e} in {text:?}"))
}

/// One run from a request in a file; messages appear as JSON Lines on standard output.
fn run_by_hand<S: Stage>(file: &str) -> ExitCode {
    let text = match std::fs::read_to_string(file) {
        Ok(text) => text,
        Err(e) => return bad_request(file, &e.to_string()),
    };
    let request: Request = match serde_json::from_str(&text) {
        Ok(request) => request,
        Err(e) => return bad_request(file, &e.to_string()),
    };
    if let Err(e) = std::fs::create_dir_all(&request.out_dir) {
        return bad_request(file, &format!("out_dir {}: {e}", request.out_dir));
    }
    match take_stdout() {
        Ok(out) => run_and_report::<S>(request, &Line::new(out)),
        Err(e) => fault(&format!("cannot set up standard output: {e}")),
    }
}

fn bad_request(file: &str, reason: &str) -> ExitCode {
    eprintln!("{file}: {reason}; --help shows a request");
    ExitCode::from(BAD_USAGE)
}

/// Runs the stage and says how it ended, in a message and in the exit code.
fn run_and_report<S: Stage>(request: Request, line: &Line) -> ExitCode {
    let result = catch_unwind(AssertUnwindSafe(|| run::<S>(request, line)));
    let panicked = || StageError::internal("the stage panicked; its log says where");
    match result.unwrap_or_else(|_| Err(panicked())) {
        Ok(done) => {
            line.send(&PluginMessage::Done(done));
            ExitCode::SUCCESS
        }
        Err(error) => {
            let code = exit_code(error.failure.kind);
            line.send(&PluginMessage::Error(error.failure));
            ExitCode::from(code)
        }
    }
}

fn run<S: Stage>(mut request: Request, line: &Line) -> Result<fibar_core::protocol::Done, StageError> {
    let threads = request.threads.max(1) as usize;
    // A second pool in one process (tests) keeps the first one's size, which changes no byte.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
    if request.params.is_null() {
        request.params = serde_json::json!({});
    }
    let params: S::Params = serde_json::from_value(request.params.clone())
        .map_err(|e| StageError::user(format!("parameters: {e}")).hint("--help lists the parameters"))?;
    let mut job = Job::new(request, full_description::<S>(), line.clone());
    job.check_inputs()?;
    S::run(params, &mut job)?;
    job.finish()
}

fn exit_code(kind: FailureKind) -> u8 {
    match kind {
        FailureKind::User => 2,
        FailureKind::Input => 3,
        FailureKind::Resource => 4,
        FailureKind::Internal => FAULT,
        FailureKind::Cancelled => 130,
    }
}

/// Standard output as a file of our own; whatever else prints to it afterwards lands on standard error, so that a
/// library's chatter cannot break the protocol.
#[cfg(unix)]
fn take_stdout() -> std::io::Result<File> {
    let own = rustix::io::dup(std::io::stdout())?;
    rustix::stdio::dup2_stdout(std::io::stderr())?;
    rustix::io::fcntl_setfd(&own, rustix::io::FdFlags::CLOEXEC)?;
    Ok(File::from(own))
}

/// Standard output as a file of our own.
#[cfg(windows)]
fn take_stdout() -> std::io::Result<File> {
    use std::os::windows::io::AsHandle;
    Ok(File::from(std::io::stdout().as_handle().try_clone_to_owned()?))
}
