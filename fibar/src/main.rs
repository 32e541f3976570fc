//! The command line of fibar: arguments in, tables and findings out. What they mean is the engine's business.

#![warn(clippy::print_stdout, clippy::print_stderr)]

mod arguments;
mod command;
mod log;
mod progress;
mod speak;
mod table;

use arguments::{Arguments, Command, PluginCommand};
use clap::Parser;
use fibar_engine::Result;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    fibar_engine::os::catch_interrupts();
    match run(&arguments) {
        Ok(code) => code,
        Err(error) => {
            if !arguments.command.logs_json() {
                speak::tell(error.render());
            }
            ExitCode::from(error.class as u8)
        }
    }
}

fn run(arguments: &Arguments) -> Result<ExitCode> {
    let common = &arguments.common;
    match &arguments.command {
        Command::Build(options) => command::build(options, common),
        Command::Verify(options) => command::verify(options, common),
        Command::Plan(options) => command::plan(options, common),
        Command::Explain(options) => command::explain(options, common),
        Command::CheckDeterminism(options) => command::check_determinism(options, common),
        Command::Cache(command) => command::cache(command, common),
        Command::Plugin(PluginCommand::Test(options)) => command::plugin_test(options, common),
        Command::Plugin(PluginCommand::List(options)) => command::plugin_list(options, common),
        Command::Plugin(PluginCommand::Describe { name }) => command::plugin_describe(name, common),
        Command::Plugin(PluginCommand::Required { recipes }) => command::plugin_required(recipes),
    }
}
