//! Small stages for the engine's own tests: one executable, whose file name says which stage it is.

use fibar_plugin::{Description, InputFile, Job, Stage, StageError, Violation, serve};
use std::time::Duration;

#[derive(serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct MakeParams {
    /// The text.
    text: String,
    /// A file whose text comes after it.
    file: Option<InputFile>,
    /// How often it is said.
    #[schemars(range(min = 1, max = 9))]
    times: u32,
}

impl Default for MakeParams {
    fn default() -> MakeParams {
        MakeParams { text: "hello".into(), file: None, times: 1 }
    }
}

/// Parameters → text.
struct MakeText;

impl Stage for MakeText {
    type Params = MakeParams;

    fn describe() -> Description {
        Description::new("make-text", "Makes a text.")
            .published("text", "text", "text.txt", "The text.")
            .seeded()
    }

    fn run(params: MakeParams, job: &mut Job) -> Result<(), StageError> {
        let mut text = params.text.repeat(params.times as usize);
        if let Some(file) = &params.file {
            text += &std::fs::read_to_string(file.path())?;
        }
        if text.is_empty() {
            return Err(StageError::user("there is nothing to say").param("/text").hint("say something"));
        }
        job.metric("text.bytes", text.len() as f64, "1");
        job.write("text", "text.txt", text.as_bytes())
    }
}

#[derive(serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct WorkParams {
    /// How long it takes.
    #[schemars(extend("unit" = "s"))]
    seconds: f64,
    /// Ignores the wish to stop.
    deaf: bool,
    /// The file it is written as.
    name: String,
}

impl Default for WorkParams {
    fn default() -> WorkParams {
        WorkParams { seconds: 0.0, deaf: false, name: "upper.txt".into() }
    }
}

/// Text → the same in capitals, after some work.
struct UpperText;

impl Stage for UpperText {
    type Params = WorkParams;

    fn describe() -> Description {
        let about = Description::new("upper-text", "Says it in capitals.").max_cores(1);
        about.input("text", "text", "What to say.").published("upper", "upper", "upper.txt", "In capitals.")
    }

    fn run(params: WorkParams, job: &mut Job) -> Result<(), StageError> {
        let steps = (params.seconds / 0.01) as u32;
        for step in 0..steps {
            std::thread::sleep(Duration::from_millis(10));
            let result = job.progress(f64::from(step) / f64::from(steps), "working");
            if !params.deaf {
                result?;
            }
        }
        let text = String::from_utf8_lossy(&job.read("text")?).to_uppercase();
        job.write("upper", &params.name, text.as_bytes())
    }
}

#[derive(serde::Deserialize, schemars::JsonSchema, Default)]
#[serde(deny_unknown_fields, default)]
struct NoParams {}

/// Every text in capitals → a folder.
struct BindText;

impl Stage for BindText {
    type Params = NoParams;

    fn describe() -> Description {
        let about = Description::new("bind-text", "Binds texts into a folder.");
        about.input_of_all("pages", "upper", "All pages.").published("book", "book", "book", "The folder.")
    }

    fn run(_: NoParams, job: &mut Job) -> Result<(), StageError> {
        let pages = job.input_paths("pages")?;
        let book = job.create_tree("book", "book")?;
        std::fs::create_dir(book.join("pages"))?;
        for (i, page) in pages.iter().enumerate() {
            std::fs::copy(page, book.join(format!("pages/{i}.txt")))?;
        }
        Ok(std::fs::write(book.join("title.txt"), format!("{} pages", pages.len()))?)
    }
}

#[derive(serde::Deserialize, schemars::JsonSchema, Default)]
#[serde(deny_unknown_fields, default)]
struct CheckParams {
    /// What must not be in the book.
    word: String,
}

/// Folder → verdict.
struct VerifyText;

impl Stage for VerifyText {
    type Params = CheckParams;

    fn describe() -> Description {
        let about = Description::new("verify-text", "Looks for a word.");
        about.input("book", "book", "The folder.").output("verdict", "verdict", "What was found.")
    }

    fn run(params: CheckParams, job: &mut Job) -> Result<(), StageError> {
        let page = std::fs::read_to_string(job.input_path("book")?.join("pages/0.txt"))?;
        if page.contains(&params.word) {
            let message = format!("{:?} is on the first page", params.word);
            job.violation(Violation { rule: "text.word".into(), message, place_mm: Some([1.0, 2.0, 3.0]) });
        }
        job.write("verdict", "verdict.json", b"{}")
    }
}

#[derive(serde::Deserialize, schemars::JsonSchema, Default)]
#[serde(deny_unknown_fields, default)]
struct PassParams {
    /// How long it takes.
    #[schemars(extend("unit" = "s"))]
    seconds: f64,
    /// What it adds to the text.
    word: String,
}

/// Text → longer text, after some work: a link of a chain.
struct PassText;

impl Stage for PassText {
    type Params = PassParams;

    fn describe() -> Description {
        let about = Description::new("pass-text", "Adds a word and passes it on.").max_cores(1);
        about.input("text", "text", "What to pass on.").output("text", "text", "The same and a word.")
    }

    fn run(params: PassParams, job: &mut Job) -> Result<(), StageError> {
        // In one piece: `cargo xtask bench` counts whatever comes on top.
        std::thread::sleep(Duration::from_secs_f64(params.seconds));
        let mut text = job.read("text")?;
        text.extend(params.word.bytes());
        job.write("text", "text.txt", &text)
    }
}

/// Text → JSON that depends on the number of threads, which no stage may do.
struct LeakText;

impl Stage for LeakText {
    type Params = NoParams;

    fn describe() -> Description {
        let about = Description::new("leak-text", "Says on how many threads it runs.");
        about.input("text", "text", "Ignored.").published("leak", "leak", "leak.json", "What it ran on.")
    }

    fn run(_: NoParams, job: &mut Job) -> Result<(), StageError> {
        let text = format!("{{\"format\": \"leak/1\", \"ran\": {{\"threads\": {}}}}}", job.threads());
        job.write("leak", "leak.json", text.as_bytes())
    }
}

fn main() -> std::process::ExitCode {
    let executable = std::env::current_exe().expect("Linux and macOS know it");
    match executable.file_stem().and_then(|name| name.to_str()) {
        Some("make-text") => serve::<MakeText>(),
        Some("upper-text") => serve::<UpperText>(),
        Some("bind-text") => serve::<BindText>(),
        Some("pass-text") => serve::<PassText>(),
        Some("leak-text") => serve::<LeakText>(),
        Some("verify-text") => serve::<VerifyText>(),
        other => panic!("no stage is called {other:?}"),
    }
}
