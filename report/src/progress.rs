//! Progress of a staged run, on a terminal.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// Bars count in parts of this whole: stages end at a step, a time, or a T_v.
const WHOLE: f64 = 10_000.0;
/// Time between two updates of the screen.
const BLINK: Duration = Duration::from_millis(100);

/// A line on stderr that says where a run is: stage, share done, steps per second, a
/// value of interest, time left. Nothing is drawn when stderr is no terminal.
pub struct Progress {
    bar: ProgressBar,
    stage: String,
    /// Step and time at the start of the stage, for its rate.
    start: (u64, Instant),
    next: Instant,
}

impl Default for Progress {
    fn default() -> Progress {
        let now = Instant::now();
        Progress { bar: ProgressBar::hidden(), stage: String::new(), start: (0, now), next: now }
    }
}

impl Progress {
    /// No stage yet; nothing is drawn.
    pub fn new() -> Progress {
        Progress::default()
    }

    /// A stage begins at this step of the run. `bounded`: [`Progress::update`] will tell
    /// which share is done; otherwise no time left is shown.
    pub fn begin(&mut self, stage: &str, step: u64, bounded: bool) {
        // indicatif draws on stderr, and not at all when that is no terminal.
        self.bar = match bounded {
            true => ProgressBar::new(WHOLE as u64),
            false => ProgressBar::new_spinner(),
        };
        let template = match bounded {
            true => "{prefix:<14} [{bar:20}] {percent:>3} %  {msg}  {eta} left",
            false => "{prefix:<14} {spinner} {elapsed}  {msg}",
        };
        // Fails on a malformed template only, and these are fixed; the default style
        // would then do.
        let style = ProgressStyle::with_template(template)
            .unwrap_or_else(|_| ProgressStyle::default_bar())
            .progress_chars("=> ");
        self.bar.set_style(style);
        self.bar.set_prefix(stage.to_owned());
        self.stage = stage.to_owned();
        let now = Instant::now();
        self.start = (step, now);
        self.next = now;
    }

    /// Something goes on elsewhere for a while; the line shows what, and for how long.
    pub fn wait(&mut self, what: &str) {
        self.begin(what, 0, false);
        self.bar.enable_steady_tick(BLINK);
    }

    /// What was waited for is done: its line stays.
    pub fn waited(&mut self) {
        let time = self.start.1.elapsed().as_secs_f64();
        self.bar.println(format!("{:<32} {time:.1} s", self.stage));
        self.bar.finish_and_clear();
    }

    /// The run is at this step, with this share of the stage done (where known). `value`
    /// says what is of interest ("T_v 0.31", "σ 9.8 kPa"); it is asked only when the line
    /// is redrawn, some ten times a second.
    pub fn update(&mut self, step: u64, share: Option<f64>, value: impl FnOnce() -> String) {
        let now = Instant::now();
        if now < self.next || self.bar.is_hidden() {
            return;
        }
        self.next = now + BLINK;
        match share {
            Some(share) => self.bar.set_position((share.clamp(0.0, 1.0) * WHOLE) as u64),
            None => self.bar.tick(),
        }
        self.bar.set_message(format!("step {step}  {:.0}/s  {}", self.rate(step, now), value()));
    }

    /// The stage is over: its line gives way to one that stays, with `result`.
    pub fn end(&mut self, step: u64, result: &str) {
        let now = Instant::now();
        let (steps, time) = (step - self.start.0, now - self.start.1);
        self.bar.println(format!(
            "{:<14} {steps} steps in {:.1} s ({:.0}/s)  {result}",
            self.stage,
            time.as_secs_f64(),
            self.rate(step, now),
        ));
        self.bar.finish_and_clear();
    }

    /// Steps per second since the stage began.
    fn rate(&self, step: u64, now: Instant) -> f64 {
        let (first, start) = self.start;
        (step - first) as f64 / (now - start).as_secs_f64().max(1e-9)
    }
}
