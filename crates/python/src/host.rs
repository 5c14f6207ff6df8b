//! Work without the interpreter lock that can be interrupted by Ctrl-C, a progress bar or a callback.
//!
//! The work is done by a separate thread. The calling thread sleeps without the lock, and checks every few milliseconds
//! for signals and progress. So a call ends within a tenth of a second after Ctrl-C in any case: work that does not
//! stop in time continues in the background, and its result is dropped.

use std::any::Any;
use std::collections::HashMap;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use pyo3::prelude::*;
use pyo3::types::PyBool;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::failure::{Ended, Failure};
use crate::repair_warning;

/// The interval at which the calling thread wakes up.
const TICK: Duration = Duration::from_millis(20);

/// The time to wait for cancelled work.
const PATIENCE: Duration = Duration::from_millis(50);

/// How a call is made: what it tells, and by how many threads it is done.
#[derive(Default)]
#[pyclass(frozen, module = "curvmesh._core")]
pub(crate) struct Call {
    /// Called with the part that is done, from 0 to 1.
    progress: Option<Py<PyAny>>,
    /// Called with the state; ends the run when it returns `False`.
    callback: Option<Py<PyAny>>,
    threads: Option<usize>,
    /// Whether Ctrl-C leaves what is best so far instead of an exception.
    keep_partial: bool,
}

#[pymethods]
impl Call {
    #[new]
    #[pyo3(signature = (progress=None, callback=None, threads=None, keep_partial=false))]
    fn new(
        progress: Option<Py<PyAny>>,
        callback: Option<Py<PyAny>>,
        threads: Option<usize>,
        keep_partial: bool,
    ) -> Self {
        Self { progress, callback, threads, keep_partial }
    }
}

/// The progress of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct State {
    pub(crate) phase: &'static str,
    /// The completed share, from 0 to 1.
    pub(crate) fraction: f64,
    /// Remaining faces, if they change.
    pub(crate) faces: Option<usize>,
    /// The number of collapses, flips, patches etc. so far.
    pub(crate) steps: u64,
    /// The cost so far, if there is one.
    pub(crate) cost: Option<f64>,
}

/// State shared by the work and the caller.
#[derive(Default)]
pub(crate) struct Watch {
    is_cancelled: AtomicBool,
    state: Mutex<State>,
    raised: Mutex<Option<PyErr>>,
}

impl Watch {
    /// Reports progress, and returns whether to continue.
    pub(crate) fn tell(&self, state: State) -> ControlFlow<()> {
        *lock(&self.state) = state;
        self.flow()
    }

    /// Whether to continue.
    pub(crate) fn flow(&self) -> ControlFlow<()> {
        if self.is_cancelled() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    pub(crate) fn is_cancelled(&self) -> bool {
        self.is_cancelled.load(Ordering::Relaxed)
    }

    /// An error if the work is cancelled: for use between steps that cannot be interrupted.
    pub(crate) fn check(&self) -> Result<(), Ended> {
        if self.is_cancelled() { Err(Ended::interrupted()) } else { Ok(()) }
    }

    /// Cancels the work because of an exception of a Python function.
    pub(crate) fn raise(&self, error: PyErr) {
        lock(&self.raised).get_or_insert(error);
        self.cancel();
    }

    fn cancel(&self) {
        self.is_cancelled.store(true, Ordering::Relaxed);
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

type Outcome<T> = Result<Result<T, Ended>, Box<dyn Any + Send>>;

/// Does the work, and returns its result.
pub(crate) fn run<T: Send + 'static>(
    py: Python<'_>,
    call: &Call,
    work: impl FnOnce(&Arc<Watch>) -> Result<T, Ended> + Send + 'static,
) -> PyResult<T> {
    let pool = pool(call.threads).map_err(|failure| failure.raise(py))?;
    let watch = Arc::new(Watch::default());
    let (send, receive) = sync_channel::<Outcome<T>>(1);
    let worker = Arc::clone(&watch);
    let threads = Arc::clone(&pool);
    let job = move || {
        let outcome = catch_unwind(AssertUnwindSafe(|| threads.install(|| work(&worker))));
        // If this fails, nobody waits for the result any more.
        let _ = send.send(outcome);
    };
    std::thread::Builder::new()
        .name("curvmesh".into())
        .spawn(job)
        .map_err(|error| Failure::internal(format!("no thread: {error}")).raise(py))?;
    let outcome = wait(py, call, &watch, receive).inspect_err(|_| abandon(&pool))?;
    repair_warning::tell(py)?;
    if let Some(error) = lock(&watch.raised).take() {
        return Err(error);
    }
    match outcome {
        Ok(result) => {
            let result = result.map_err(|ended| ended.raise(py))?;
            call.finish(py)?;
            Ok(result)
        }
        Err(panic) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("unknown");
            Err(Failure::internal(format!("a defect of curvmesh: {text}")).raise(py))
        }
    }
}

/// Sleeps until the work is done, and reports its progress.
fn wait<T: Send>(
    py: Python<'_>,
    call: &Call,
    watch: &Watch,
    mut receive: Receiver<Outcome<T>>,
) -> PyResult<Outcome<T>> {
    let mut told = State::default();
    loop {
        let answer;
        (answer, receive) = py.detach(move || (receive.recv_timeout(TICK), receive));
        match answer {
            Ok(outcome) => return Ok(outcome),
            Err(RecvTimeoutError::Disconnected) => {
                return Err(Failure::internal("the work has vanished").raise(py));
            }
            Err(RecvTimeoutError::Timeout) => {}
        }
        let now = *lock(&watch.state);
        let went = py.check_signals().map_err(|error| (error, call.keep_partial)).and_then(|()| {
            if now == told {
                return Ok(());
            }
            told = now;
            let goes_on = call.tell(py, &now).map_err(|error| (error, false))?;
            if !goes_on {
                watch.cancel();
            }
            Ok(())
        });
        if let Err((error, keeps)) = went {
            watch.cancel();
            if keeps {
                continue;
            }
            // Work that does not stop now is abandoned.
            py.detach(move || drop(receive.recv_timeout(PATIENCE)));
            return Err(error);
        }
    }
}

impl Call {
    /// Reports the state; the run is cancelled if the callback returns `False`.
    fn tell(&self, py: Python<'_>, state: &State) -> PyResult<bool> {
        if let Some(progress) = &self.progress {
            progress.call1(py, (state.fraction.clamp(0.0, 1.0),))?;
        }
        let Some(callback) = &self.callback else { return Ok(true) };
        let State { phase, fraction, faces, steps, cost } = *state;
        let answer = callback.call1(py, (phase, fraction, faces, steps, cost))?;
        Ok(!answer.bind(py).is(PyBool::new(py, false)))
    }

    /// Reports the completion of the work.
    fn finish(&self, py: Python<'_>) -> PyResult<()> {
        if let Some(progress) = &self.progress {
            progress.call1(py, (1.0,))?;
        }
        Ok(())
    }
}

/// Pools by process and number of threads; a forked process has no threads of its parent.
type Pools = HashMap<(u32, Option<usize>), Arc<ThreadPool>>;

static POOLS: Mutex<Option<Pools>> = Mutex::new(None);

/// Removes the pool, so that no other call waits for threads that are busy with abandoned work.
fn abandon(pool: &Arc<ThreadPool>) {
    if let Some(pools) = lock(&POOLS).as_mut() {
        pools.retain(|_, other| !Arc::ptr_eq(other, pool));
    }
}

fn pool(threads: Option<usize>) -> Result<Arc<ThreadPool>, Failure> {
    const MOST: usize = 1024;
    if let Some(count) = threads.filter(|count| !(1..=MOST).contains(count)) {
        return Err(Failure::option(format!("threads is {count}; it must be from 1 to {MOST}")));
    }
    let mut pools = lock(&POOLS);
    let pools = pools.get_or_insert_default();
    let key = (std::process::id(), threads);
    if let Some(pool) = pools.get(&key) {
        return Ok(Arc::clone(pool));
    }
    let mut builder = ThreadPoolBuilder::new().thread_name(|i| format!("curvmesh {i}"));
    if let Some(count) = threads {
        builder = builder.num_threads(count);
    }
    let pool = builder.build().map_err(|error| Failure::internal(error.to_string()))?;
    let pool = Arc::new(pool);
    pools.insert(key, Arc::clone(&pool));
    Ok(pool)
}
