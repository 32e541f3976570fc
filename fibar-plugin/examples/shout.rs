//! A whole stage: repeats a text in capitals. Try `cargo run --example shout -- --help`.

use fibar_plugin::{Description, Job, Stage, StageError, serve};

#[derive(serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct Params {
    /// How often to say it.
    #[schemars(range(min = 1, max = 9), extend("unit" = "1"))]
    times: u32,
}

impl Default for Params {
    fn default() -> Params {
        Params { times: 2 }
    }
}

struct Shout;

impl Stage for Shout {
    type Params = Params;

    fn describe() -> Description {
        Description::new("shout", "Repeats a text in capitals.")
            .version(env!("CARGO_PKG_VERSION"))
            .input("text", "text", "What to repeat.")
            .published("shout", "text", "shout.txt", "The text, louder.")
    }

    fn run(params: Params, job: &mut Job) -> Result<(), StageError> {
        let text =
            String::from_utf8(job.read("text")?).map_err(|_| StageError::input("the text is not UTF-8"))?;
        job.progress(0.5, "shouting")?;
        let loud = text.to_uppercase().repeat(params.times as usize);
        job.metric("shout.bytes", loud.len() as f64, "1");
        job.write("shout", "shout.txt", loud.as_bytes())
    }
}

fn main() -> std::process::ExitCode {
    serve::<Shout>()
}
