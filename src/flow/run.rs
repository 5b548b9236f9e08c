//! Wires stages into a flow and runs it: every stage on its own named threads, all in one scope.
//!
//! ```
//! # use gonio::Result;
//! # use gonio::flow::{End, Flow, Fold, Map, Meter, Outlet, Source, StopSignal};
//! struct Upto(u64);
//! impl Source for Upto {
//!     type Out = u64;
//!     fn run(self, out: &mut Outlet<'_, u64>) -> Result<()> {
//!         (0..self.0).try_for_each(|n| out.send(n))
//!     }
//! }
//! struct Square;
//! impl Map for Square {
//!     type In = u64;
//!     type Out = u64;
//!     type Scratch = ();
//!     fn scratch(&self) -> Result<()> {
//!         Ok(())
//!     }
//!     fn apply(&self, _: &mut (), n: u64, out: &mut Outlet<'_, u64>) -> Result<()> {
//!         out.send(n * n)
//!     }
//! }
//! struct Sum(u64);
//! impl Fold for Sum {
//!     type In = u64;
//!     type Out = u64;
//!     fn take(&mut self, n: u64, _: &Meter) -> Result<()> {
//!         self.0 += n;
//!         Ok(())
//!     }
//!     fn finish(self, _: End, _: &Meter) -> Result<u64> {
//!         Ok(self.0)
//!     }
//! }
//! let flow = Flow::source(&StopSignal::new(), "count", Upto(5)).map("square", Square, 2, 4).fold("sum", Sum(0), 4);
//! let meters = flow.meters(); // to be read by another thread meanwhile
//! assert_eq!(flow.run()?, 30);
//! assert_eq!(meters[2].read().items_in, 5);
//! # Ok::<(), gonio::Error>(())
//! ```

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;

use super::channel::{self, Receiver, Sender};
use super::meter::{Clock, Meter};
use super::mutex::lock;
use super::order::Order;
use super::spawn;
use super::stage::{End, Fold, Map, Outlet, Source};
use super::stop::{Bomb, StopSignal};
use crate::base::{Error, Result};

/// A flow that still lacks its fold; its last stage produces `T`.
#[must_use = "a flow without a fold does nothing"]
pub struct Flow<'env, T> {
    wiring: Wiring<'env>,
    /// Starts the last stage with its output channel, which is made when the stage after it is known.
    connect: Box<dyn FnOnce(Sender<T>) -> Vec<Task<'env>> + 'env>,
}

/// A flow that can run; `R` is the fold's result.
#[must_use = "a flow does nothing until it runs"]
pub struct Ready<'env, R> {
    wiring: Wiring<'env>,
    result: Arc<Mutex<Option<R>>>,
}

struct Wiring<'env> {
    stop: StopSignal,
    /// Set when the source was cut short, before its end is said.
    cut: Arc<AtomicBool>,
    meters: Vec<Arc<Meter>>,
    tasks: Vec<Task<'env>>,
}

/// The work of one thread.
struct Task<'env> {
    stage: String,
    thread: String,
    body: Box<dyn FnOnce() -> Result<()> + Send + 'env>,
    /// The thread's place among the workers of its stage. Without a first one, nothing works.
    worker: usize,
    /// What is done instead where the system does not grant the thread and others do its work.
    absent: Box<dyn FnOnce() + Send + 'env>,
}

impl<'env> Task<'env> {
    /// The one thread of a stage.
    fn only(stage: String, body: impl FnOnce() -> Result<()> + Send + 'env) -> Self {
        Task { thread: stage.clone(), stage, body: Box::new(body), worker: 0, absent: Box::new(|| ()) }
    }
}

impl<'env, T: Send + 'env> Flow<'env, T> {
    /// Begins with a source.
    pub fn source<S: Source<Out = T> + 'env>(stop: &StopSignal, name: &str, source: S) -> Self {
        let meter = Arc::new(Meter::new(name, 1, 0, source.total()));
        let cut = Arc::new(AtomicBool::new(false));
        let wiring =
            Wiring { stop: stop.clone(), cut: Arc::clone(&cut), meters: vec![Arc::clone(&meter)], tasks: Vec::new() };
        let (stop, stage) = (stop.clone(), name.to_owned());
        let connect = move |sender| vec![Task::only(stage, move || run_source(source, sender, &meter, &stop, &cut))];
        Flow { wiring, connect: Box::new(connect) }
    }

    /// Adds a map on this many workers (0 counts as 1), with at most `queue` items waiting before it.
    pub fn map<M: Map<In = T> + 'env>(self, name: &str, map: M, workers: usize, queue: usize) -> Flow<'env, M::Out>
    where
        M::Out: 'env,
    {
        let workers = workers.max(1);
        let (wiring, input, meter) = self.then(name, workers, queue);
        let (stop, stage) = (wiring.stop.clone(), name.to_owned());
        let connect = move |sender| {
            let shared = Arc::new((map, Order::new(workers, &stop, sender)));
            (0..workers)
                .map(|worker| {
                    let (shared, input, meter) = (Arc::clone(&shared), input.clone(), Arc::clone(&meter));
                    let (others, lacking) = (Arc::clone(&shared), Arc::clone(&meter));
                    let body = move || run_worker(&shared.0, &shared.1, &input, &meter);
                    let absent = move || {
                        others.1.leave();
                        lacking.lacks_worker();
                    };
                    let (thread, stage) = (format!("{stage}-{worker}"), stage.clone());
                    Task { stage, thread, body: Box::new(body), worker, absent: Box::new(absent) }
                })
                .collect()
        };
        Flow { wiring, connect: Box::new(connect) }
    }

    /// Ends with a fold, with at most `queue` items waiting before it.
    pub fn fold<F: Fold<In = T> + 'env>(self, name: &str, fold: F, queue: usize) -> Ready<'env, F::Out>
    where
        F::Out: 'env,
    {
        let (mut wiring, input, meter) = self.then(name, 1, queue);
        let result = Arc::new(Mutex::new(None));
        let (slot, cut, stage) = (Arc::clone(&result), Arc::clone(&wiring.cut), name.to_owned());
        let body = move || {
            let out = run_fold(fold, &input, &meter, &cut)?;
            *lock(&slot) = Some(out);
            Ok(())
        };
        wiring.tasks.push(Task::only(stage, body));
        Ready { wiring, result }
    }

    /// Connects the last stage to a new one.
    fn then(self, name: &str, workers: usize, queue: usize) -> (Wiring<'env>, Receiver<T>, Arc<Meter>) {
        let mut wiring = self.wiring;
        let meter = Arc::new(Meter::new(name, workers, queue, None));
        let last = wiring.meters.last().unwrap_or(&meter);
        let (sender, receiver) = channel::bounded(queue, &wiring.stop, last, &meter);
        wiring.meters.push(Arc::clone(&meter));
        wiring.tasks.extend((self.connect)(sender));
        (wiring, receiver, meter)
    }
}

impl<R: Send> Ready<'_, R> {
    /// The stages' meters, in order. They outlive the run.
    pub fn meters(&self) -> Vec<Arc<Meter>> {
        self.wiring.meters.clone()
    }

    /// Runs to the end and returns the fold's result. All threads have joined by then.
    ///
    /// # Errors
    /// The first error of any stage; `Error::Panic` if one panicked; `Error::Interrupted` if the run was asked to stop
    /// and the source was cut short: then all items in flight have been folded and the fold has finished.
    pub fn run(self) -> Result<R> {
        let Wiring { stop, cut, mut tasks, .. } = self.wiring;
        // Every stage gets its first thread before any gets another.
        tasks.sort_by_key(|task| task.worker);
        thread::scope(|scope| {
            let mut all_granted = true;
            for Task { stage, thread, body, worker, absent } in tasks {
                let needed = worker == 0;
                if !needed && !all_granted {
                    absent();
                    continue;
                }
                let inner = stop.clone();
                let live = move || {
                    let bomb = Bomb::arm(&inner, &stage);
                    match catch_unwind(AssertUnwindSafe(body)) {
                        Ok(Ok(())) => bomb.defuse(),
                        Ok(Err(why)) => bomb.blow(why),
                        Err(payload) => bomb.blow_panic(&*payload),
                    }
                };
                match spawn::start(scope, &thread, needed, live) {
                    Ok(()) => {}
                    Err(why) if needed => stop.halt(spawn::refused(&thread, &why)),
                    Err(_) => {
                        all_granted = false;
                        absent();
                    }
                }
            }
        });
        if let Some(cause) = stop.take_cause() {
            return Err(cause);
        }
        let result = lock(&self.result).take();
        if cut.load(Ordering::Acquire) { Err(Error::Interrupted) } else { result.ok_or(Error::Interrupted) }
    }
}

fn run_source<S: Source>(
    source: S,
    mut sender: Sender<S::Out>,
    meter: &Meter,
    stop: &StopSignal,
    cut: &AtomicBool,
) -> Result<()> {
    let mut clock = Clock::start(meter);
    // A source that was told to stop counts as cut short: it may not have produced all.
    let stopping = || {
        stop.draining() && {
            cut.store(true, Ordering::Release);
            true
        }
    };
    let mut send = |item| if stopping() { Err(Error::Interrupted) } else { sender.send(item, &mut clock) };
    match source.run(&mut Outlet::new(meter, &stopping, &mut send)) {
        Err(why) if !(why.is_interrupt() && cut.load(Ordering::Acquire)) || stop.halted() => Err(why),
        _ => {
            sender.finish();
            Ok(())
        }
    }
}

fn run_worker<M: Map>(map: &M, order: &Order<M::Out>, input: &Receiver<M::In>, meter: &Meter) -> Result<()> {
    let mut clock = Clock::start(meter);
    let mut scratch = map.scratch()?;
    loop {
        order.permit(&mut clock)?;
        let Some((position, item)) = input.recv(&mut clock)? else { break };
        let mut place = order.place(position);
        let mut send = |output| place.send(output, &mut clock);
        map.apply(&mut scratch, item, &mut Outlet::new(meter, &|| false, &mut send))?;
        place.finish(&mut clock)?;
    }
    order.leave();
    Ok(())
}

fn run_fold<F: Fold>(mut fold: F, input: &Receiver<F::In>, meter: &Meter, cut: &AtomicBool) -> Result<F::Out> {
    let mut clock = Clock::start(meter);
    while let Some((_, item)) = input.recv(&mut clock)? {
        fold.take(item, meter)?;
    }
    fold.finish(if cut.load(Ordering::Acquire) { End::Drained } else { End::Complete }, meter)
}
