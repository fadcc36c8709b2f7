//! CHOLMOD's factorization with its largest parts on an NVIDIA GPU, and the way
//! back to the CPU whenever that fails.

use std::sync::{Arc, Mutex, PoisonError};

use cholmod_sys::cuda::{self, Device};

use super::super::{GpuOptions, GpuWork, Placement, SymmetricCsc};
use super::raw::{BUFFER_UNIT, Calls, DEVICE_BUFFERS, Fault, HOST_BUFFERS, Lendable, Raw};

/// Part of the free memory of a device that is taken unless the user says
/// otherwise: a second program, or a second solver, finds room beside it.
const SHARE: f64 = 0.4;

/// Largest backward error of any row after a factorization on a GPU. The CPU's is
/// some 10⁻¹⁵.
const ERROR_LIMIT: f64 = 1e-10;

/// Supernodes of more entries than 2³¹ are more than CHOLMOD's kernels can count
/// (bytes).
const LARGEST_BUFFER: usize = 16 << 30;

/// A device with what CHOLMOD holds on it.
pub(super) struct Session {
    device: u32,
    state: State,
}

enum State {
    /// Nothing has been asked of the device yet.
    Fresh,
    Open {
        device: Device,
        /// Most memory that may be taken (bytes).
        limit: u64,
        gpu: Option<Box<Lendable>>,
    },
    /// It has failed, and is not asked again.
    Failed(String),
}

/// Sessions by what was asked for. They last as long as the process: pinned
/// memory is slow to get.
static SESSIONS: Mutex<Vec<(GpuOptions, Arc<Mutex<Session>>)>> = Mutex::new(Vec::new());

/// The session of a device, which all factors that use it share.
pub(super) fn session(options: GpuOptions) -> Arc<Mutex<Session>> {
    let mut sessions = SESSIONS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, session)) = sessions.iter().find(|(known, _)| *known == options) {
        return Arc::clone(session);
    }
    let session = Session { device: options.device, state: State::Fresh };
    let session = Arc::new(Mutex::new(session));
    sessions.push((options, Arc::clone(&session)));
    session
}

/// Factors a matrix, on the device of a session if that goes well and else on
/// the CPU; the result is right in both cases.
pub(super) fn factorize(
    raw: &mut Raw,
    a: &SymmetricCsc,
    options: GpuOptions,
    session: &Mutex<Session>,
) -> (Result<(), Fault>, Placement) {
    // A panic while the device was in use: what is on it is not trusted.
    let mut session = match session.lock() {
        Ok(session) => session,
        Err(poisoned) => {
            let mut session = poisoned.into_inner();
            session.state = State::Failed("an earlier factorization broke off".to_owned());
            session
        }
    };
    match session.factorize(raw, a, options) {
        Ok(work) => (Ok(()), Placement::Gpu(work)),
        Err(reason) => {
            drop(session);
            (raw.factorize(a), Placement::Fallback { reason })
        }
    }
}

impl Session {
    /// # Errors
    /// Why the CPU has to do it.
    fn factorize(
        &mut self,
        raw: &mut Raw,
        a: &SymmetricCsc,
        options: GpuOptions,
    ) -> Result<GpuWork, String> {
        let Some(need) = raw.buffer_need() else {
            return Err("the matrix is too small for a GPU".to_owned());
        };
        self.open(options)?;
        let done = self.attempt(raw, a, need);
        if let Err(Refusal::Broken(reason)) = &done {
            // What is held on the device goes with the old state.
            self.state = State::Failed(reason.clone());
        }
        done.map_err(|refusal| match refusal {
            Refusal::Broken(reason) | Refusal::Unsuitable(reason) => reason,
        })
    }

    /// Finds the device in the first call; makes it the thread's in each.
    fn open(&mut self, options: GpuOptions) -> Result<(), String> {
        if let State::Failed(reason) = &self.state {
            return Err(reason.clone());
        }
        let device = match cuda::use_device(self.device) {
            Ok(device) => device,
            Err(reason) => {
                self.state = State::Failed(reason.clone());
                return Err(reason);
            }
        };
        if matches!(self.state, State::Fresh) {
            let limit = options.memory.unwrap_or((SHARE * device.memory_free as f64) as u64);
            self.state = State::Open { device, limit, gpu: None };
        }
        Ok(())
    }

    fn attempt(
        &mut self,
        raw: &mut Raw,
        a: &SymmetricCsc,
        need: usize,
    ) -> Result<GpuWork, Refusal> {
        let State::Open { device, limit, gpu } = &mut self.state else {
            return Err(Refusal::Unsuitable("the device is not open".to_owned()));
        };
        let most = (*limit / DEVICE_BUFFERS as u64).min(pinnable() / HOST_BUFFERS as u64);
        let most = (most as usize).min(LARGEST_BUFFER) / BUFFER_UNIT * BUFFER_UNIT;
        // Networks of one run differ little: room for a larger one comes at once.
        let wish = (need + need / 4).next_multiple_of(BUFFER_UNIT);
        let buffer = wish.min(most);
        if buffer < raw.least_buffer().min(need) {
            let reason = format!(
                "the matrix needs {} MB on the GPU, and {} MB may be taken",
                megabytes(raw.least_buffer().min(need) * DEVICE_BUFFERS),
                megabytes(*limit as usize)
            );
            return Err(Refusal::Unsuitable(reason));
        }
        let held = gpu.as_ref().map_or(0, |gpu| gpu.buffer());
        if held < need.min(most) {
            // The old memory first: both together may be too much.
            *gpu = None;
            let least = need.next_multiple_of(BUFFER_UNIT).min(buffer);
            let taken = Lendable::new(buffer).or_else(|_| Lendable::new(least)).map_err(|why| {
                let size = megabytes(buffer * DEVICE_BUFFERS);
                Refusal::Broken(format!("{size} MB cannot be taken on the GPU: {why}"))
            })?;
            *gpu = Some(Box::new(taken));
        }
        let Some(gpu) = gpu else {
            return Err(Refusal::Unsuitable("there is no memory on the GPU".to_owned()));
        };
        cuda::open_ledger();
        if need <= gpu.buffer() {
            raw.allow_gpu();
        } else if raw.cut_supernodes(a, gpu).is_err() {
            let why = cuda::read_ledger().error();
            return Err(Refusal::Broken(why.unwrap_or_else(|| "the analysis fails".to_owned())));
        } else if raw.buffer_need().is_none_or(|need| need > gpu.buffer()) {
            return Err(Refusal::Unsuitable("its supernodes do not fit on the GPU".to_owned()));
        }
        let (result, calls) = raw.factorize_on(a, gpu, rayon::current_num_threads());
        let ledger = cuda::read_ledger();
        if let Some(error) = ledger.error() {
            return Err(Refusal::Broken(format!("{}: {error}", device.name)));
        }
        // The CPU says what is wrong with the matrix, if anything is.
        result.map_err(|fault| {
            Refusal::Unsuitable(match fault {
                Fault::NotPositiveDefinite | Fault::SmallPivot => {
                    "a pivot is not positive or very small".to_owned()
                }
                Fault::OutOfMemory => "the host's memory is short".to_owned(),
                Fault::TooLarge => "the matrix is too large for a GPU".to_owned(),
                Fault::Refused(what) => what.trim().lines().next().unwrap_or_default().to_owned(),
            })
        })?;
        let (_, flops) = raw.counts();
        let work = work(device, &ledger, calls, flops, gpu.buffer());
        if work.calls() == 0 || ledger.blas_calls == 0 {
            let what = "no part of the matrix is large enough for the GPU";
            return Err(Refusal::Unsuitable(what.to_owned()));
        }
        check(raw, a).map_err(|why| Refusal::Broken(format!("{}: {why}", device.name)))?;
        Ok(work)
    }
}

/// Why the CPU has to do it.
enum Refusal {
    /// The device has failed and is not asked again.
    Broken(String),
    /// The device is well, but not for this matrix.
    Unsuitable(String),
}

fn work(
    device: &Device,
    ledger: &cuda::Ledger,
    calls: Calls,
    flops: f64,
    buffer: usize,
) -> GpuWork {
    GpuWork {
        name: device.name.clone(),
        syrk_calls: calls.syrk,
        gemm_calls: calls.gemm,
        potrf_calls: calls.potrf,
        trsm_calls: calls.trsm,
        flops: ledger.blas_flops,
        share: ledger.blas_flops / flops,
        bytes_to_device: ledger.bytes_to_device,
        bytes_from_device: ledger.bytes_from_device,
        blas_calls: ledger.blas_calls,
        memory: (buffer * DEVICE_BUFFERS) as u64,
    }
}

/// Solves once: a device that computes nonsense does not say so. Each row of the
/// system must hold for itself, for conductances span ten decades (the
/// componentwise backward error of Oettli and Prager 1964).
fn check(raw: &mut Raw, a: &SymmetricCsc) -> Result<(), String> {
    let b = vec![1.0; a.n];
    let mut x = vec![0.0; a.n];
    raw.solve(&b, &mut x).map_err(|_| "its factor cannot be solved with".to_owned())?;
    let (mut residual, mut size) = (b.clone(), b);
    for j in 0..a.n {
        for k in a.col_ptr[j] as usize..a.col_ptr[j + 1] as usize {
            let (i, value) = (a.row_idx[k] as usize, a.values[k]);
            residual[i] -= value * x[j];
            size[i] += (value * x[j]).abs();
            if i != j {
                residual[j] -= value * x[i];
                size[j] += (value * x[i]).abs();
            }
        }
    }
    let worst = residual.iter().zip(&size).map(|(r, s)| r.abs() / s).fold(0.0, largest);
    // Not `>`: an error that is no number must not pass.
    if worst <= ERROR_LIMIT {
        Ok(())
    } else {
        Err(format!("its factor is wrong, with a backward error of {worst:.1e}"))
    }
}

/// The larger of two, or the one that is no number: `f64::max` would drop it.
fn largest(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// Memory of the host that may be pinned (bytes): half of what is available, where
/// the system tells. More would leave none for the factor.
fn pinnable() -> u64 {
    let text = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"));
    let kib = line.and_then(|l| l.trim().strip_suffix("kB")?.trim().parse::<u64>().ok());
    kib.map_or(u64::MAX, |kib| kib * 1024 / 2)
}

fn megabytes(bytes: usize) -> usize {
    bytes.div_ceil(1_000_000)
}
