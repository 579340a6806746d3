//! Several threads on one lattice: each advances its own strips, in lockstep.
//!
//! For each command the leader computes the bulk's position, posts this position and the displacements at the sides of
//! its own strips, and increments the command counter. The other threads see the new count, execute the command, post
//! their results, and report. There is one exchange per step, through a board of atomic words without locks; strips
//! share only what their neighbours need. Sums are posted strip by strip and added in the order of the strips, so that
//! results equal those of one thread to the last bit.

use std::hint::spin_loop;
use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::{Scope, ScopedJoinHandle, yield_now};

use super::contact::{ContactForce, ContactSums};
use super::real::Real;
use super::strip::{BulkPosition, Side, Strip};

/// Command to all threads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Command {
    Step,
    BeginDrive,
    PostForces,
    Finish,
}

impl Command {
    const ALL: [Self; 4] = [Self::Step, Self::BeginDrive, Self::PostForces, Self::Finish];
}

/// Value in `Board::done` of a thread that panicked: larger than every command number, so that the leader does not wait
/// for the thread.
const PANICKED: u64 = u64::MAX;

/// Number of times that a thread polls a word before it yields its core.
///
/// After a wait in which the thread yielded, the next wait has half as many polls: with more threads than cores, the
/// awaited thread may need this core. After a wait that ended during polling, the next wait has twice as many polls.
#[derive(Debug)]
struct Patience(u32);

impl Patience {
    /// Maximum number of polls: more than any wait for a step takes if every thread has a core.
    const MOST: u32 = 4000;
    /// Minimum number of polls.
    const LEAST: u32 = 1;

    fn wait_until(&mut self, condition: impl Fn() -> bool) {
        for _ in 0..self.0 {
            if condition() {
                self.0 = (2 * self.0).min(Self::MOST);
                return;
            }
            spin_loop();
        }
        self.0 = (self.0 / 2).max(Self::LEAST);
        while !condition() {
            yield_now();
        }
    }
}

/// An f64 in an atomic word; the acquire and release of the command counter order accesses to it.
#[derive(Debug, Default)]
struct Number(AtomicU64);

impl Number {
    fn post(&self, value: f64) {
        self.0.store(value.to_bits(), Ordering::Relaxed);
    }

    fn read(&self) -> f64 {
        f64::from_bits(self.0.load(Ordering::Relaxed))
    }
}

/// Results of a strip that other threads read.
#[derive(Debug)]
struct StripBoard {
    /// Displacements in the columns at the left and right sides (second index), after even and after odd steps (first
    /// index): a thread may post the next step while another thread still reads the last.
    edges: [[Vec<Number>; 2]; 2],
    top_row_force: Number,
    /// Sums of friction, normal and sliding forces over the contact blocks.
    sums: [Number; 3],
    all_have_slipped: AtomicU64,
    /// Normal force and friction force of every contact block, in units of k l (spring stiffness times lattice
    /// spacing).
    forces: Vec<[Number; 2]>,
}

/// Words that all threads share: the command, the position of the bulk, and the results of the strips.
#[derive(Debug)]
struct Board {
    strips: Vec<StripBoard>,
    periodic: bool,
    /// Position of the bulk and of the moving frame, as in [`BulkPosition`].
    bulk: [Number; 3],
    /// Current command, an index into [`Command::ALL`].
    command: AtomicU64,
    /// Sequence number of the current command; 0 before the first.
    command_number: AtomicU64,
    /// Sequence number of the last completed command of each thread except the leader.
    done: Vec<AtomicU64>,
}

impl Board {
    fn new<R: Real>(strips: &[Strip<R>], periodic: bool, others: usize) -> Self {
        let numbers = |count: usize| (0..count).map(|_| Number::default()).collect::<Vec<_>>();
        let strips = strips
            .iter()
            .map(|strip| StripBoard {
                edges: [(); 2].map(|()| [(); 2].map(|()| numbers(strip.edge_len()))),
                top_row_force: Number::default(),
                sums: Default::default(),
                all_have_slipped: AtomicU64::new(0),
                forces: strip.contact.forces().map(|_| Default::default()).collect(),
            })
            .collect();
        Self {
            strips,
            periodic,
            bulk: Default::default(),
            command: AtomicU64::new(0),
            command_number: AtomicU64::new(0),
            done: (0..others).map(|_| AtomicU64::new(0)).collect(),
        }
    }

    /// Posts the data of strip `number` that other threads need after step `step`.
    fn post<R: Real>(&self, number: usize, strip: &Strip<R>, step: u64) {
        let board = &self.strips[number];
        board.top_row_force.post(strip.top_row_force());
        if self.strips.len() == 1 && self.periodic {
            return;
        }
        let [left, right] = &board.edges[(step % 2) as usize];
        strip.edge(Side::Left, |at, value| left[at].post(value));
        strip.edge(Side::Right, |at, value| right[at].post(value));
    }

    /// Copies the columns next to strip `number`, in their state after step `step`, to the ghost columns of `strip`. A
    /// ghost column beyond a free side is set to zero.
    fn join<R: Real>(&self, number: usize, strip: &mut Strip<R>, step: u64) {
        let count = self.strips.len();
        if count == 1 && self.periodic {
            strip.join_sides();
            return;
        }
        let before = number.checked_sub(1).or(self.periodic.then_some(count - 1));
        let after = if number + 1 < count { Some(number + 1) } else { self.periodic.then_some(0) };
        let edge = |of: usize, side: usize| &self.strips[of].edges[(step % 2) as usize][side];
        // There is no block beyond a free side; zeros keep the values that vectors write there bounded.
        let (left, right) = (before.map(|of| edge(of, 1)), after.map(|of| edge(of, 0)));
        strip.set_image(Side::Left, |at| left.map_or(0.0, |edge| edge[at].read()));
        strip.set_image(Side::Right, |at| right.map_or(0.0, |edge| edge[at].read()));
    }

    /// Takes step `step` of strip `number` and posts the results.
    fn step<R: Real>(&self, number: usize, strip: &mut Strip<R>, step: u64) {
        self.join(number, strip, step - 1);
        let [x, height, carried] = self.bulk.each_ref().map(Number::read);
        let sums = strip.step(BulkPosition { x, height, carried });
        let board = &self.strips[number];
        for (word, sum) in board.sums.iter().zip([sums.friction, sums.normal, sums.sliding]) {
            word.post(sum);
        }
        board.all_have_slipped.store(u64::from(strip.contact.all_have_slipped()), Ordering::Relaxed);
        self.post(number, strip, step);
    }

    fn post_forces<R: Real>(&self, number: usize, strip: &Strip<R>) {
        for ([normal, friction], force) in self.strips[number].forces.iter().zip(strip.contact.forces()) {
            normal.post(force.normal);
            friction.post(force.friction);
        }
    }

    /// Executes `command` on `strips`, the first of which has the number `first`; `step` counts the steps taken.
    fn work<R: Real>(&self, command: Command, first: usize, strips: &mut [Strip<R>], step: &mut u64) {
        *step += u64::from(command == Command::Step);
        for (number, strip) in (first..).zip(strips) {
            match command {
                Command::Step => self.step(number, strip, *step),
                Command::BeginDrive => strip.contact.begin_drive(),
                Command::PostForces => self.post_forces(number, strip),
                Command::Finish => {}
            }
        }
    }
}

/// The strips of the leader, which is the thread of the caller, and the threads that own the other strips.
#[derive(Debug)]
pub struct StripWorkers<'scope, 'a, R> {
    board: Arc<Board>,
    own: Vec<Strip<'a, R>>,
    others: Vec<ScopedJoinHandle<'scope, Vec<Strip<'a, R>>>>,
    patience: Patience,
    command_number: u64,
    step: u64,
}

impl<'scope, 'a: 'scope, R: Real> StripWorkers<'scope, 'a, R> {
    /// Distributes `strips` over the thread of the caller and threads in the scope of `threads`. The number in
    /// `threads` is the maximum of threads, including the caller; with `None` only the thread of the caller is used.
    pub fn new(
        mut strips: Vec<Strip<'a, R>>,
        periodic: bool,
        threads: Option<(&'scope Scope<'scope, '_>, usize)>,
    ) -> Self {
        let count = strips.len();
        let most = threads.map_or(1, |(_, most)| most).clamp(1, count);
        let board = Arc::new(Board::new(&strips, periodic, most - 1));
        for (number, strip) in strips.iter().enumerate() {
            board.post(number, strip, 0);
        }
        let mut others = Vec::new();
        if let Some((scope, _)) = threads {
            for thread in (1..most).rev() {
                let first = count * thread / most;
                let (board, own) = (Arc::clone(&board), strips.split_off(first));
                others.push(scope.spawn(move || run_worker(&board, thread - 1, first, own)));
            }
        }
        others.reverse();
        Self { board, own: strips, others, patience: Patience(Patience::MOST), command_number: 0, step: 0 }
    }

    /// Issues a command, executes it on the strips of the leader, and waits for the other threads.
    fn issue(&mut self, command: Command) {
        self.command_number += 1;
        self.board.command.store(command as u64, Ordering::Relaxed);
        self.board.command_number.store(self.command_number, Ordering::Release);
        self.board.work(command, 0, &mut self.own, &mut self.step);
        self.wait_for_workers();
    }

    /// Waits until all threads have completed the current command.
    ///
    /// # Panics
    /// With the panic of another thread, if one panicked.
    fn wait_for_workers(&mut self) {
        for done in &self.board.done {
            self.patience.wait_until(|| done.load(Ordering::Acquire) >= self.command_number);
        }
        if self.board.done.iter().any(|done| done.load(Ordering::Relaxed) == PANICKED) {
            self.resume_worker_panic();
        }
    }

    /// Stops all threads after a thread has panicked, and resumes its panic.
    fn resume_worker_panic(&mut self) {
        self.stop_workers();
        for other in self.others.drain(..) {
            if let Err(panic) = other.join() {
                resume_unwind(panic);
            }
        }
    }

    /// Vertical force of the top rows of all strips on the bulk at zero displacement of the bulk, in units of k l
    /// (spring stiffness times lattice spacing).
    pub fn top_row_force(&self) -> f64 {
        self.board.strips.iter().map(|strip| strip.top_row_force.read()).sum()
    }

    /// Takes one step with the bulk at `bulk`; returns the sums of forces over the contact row at the beginning of the
    /// step.
    pub fn step(&mut self, bulk: BulkPosition) -> ContactSums {
        for (word, value) in self.board.bulk.iter().zip([bulk.x, bulk.height, bulk.carried]) {
            word.post(value);
        }
        self.issue(Command::Step);
        let mut sums = ContactSums::default();
        for strip in &self.board.strips {
            let [friction, normal, sliding] = strip.sums.each_ref().map(Number::read);
            sums.add(ContactSums { friction, normal, sliding, across: 0.0 });
        }
        sums
    }

    pub fn begin_drive(&mut self) {
        self.issue(Command::BeginDrive);
    }

    /// Whether every contact block has slipped since the drive began.
    pub fn all_have_slipped(&self) -> bool {
        self.board.strips.iter().all(|strip| strip.all_have_slipped.load(Ordering::Relaxed) == 1)
    }

    /// Forces on the contact blocks at the last force evaluation, left to right.
    pub fn contact_forces(&mut self) -> Vec<ContactForce> {
        self.issue(Command::PostForces);
        let forces = self.board.strips.iter().flat_map(|strip| &strip.forces);
        let read = |[normal, friction]: &[Number; 2]| ContactForce { normal: normal.read(), friction: friction.read() };
        forces.map(read).collect()
    }

    /// Stops the threads; the leader then owns all strips.
    pub fn finish(&mut self) {
        if !self.others.is_empty() {
            self.issue(Command::Finish);
        }
        for other in self.others.drain(..) {
            self.own.extend(other.join().unwrap_or_else(|panic| resume_unwind(panic)));
        }
    }

    /// Strips of the leader; after [`StripWorkers::finish`] these are all strips.
    pub fn own(&self) -> &[Strip<'a, R>] {
        &self.own
    }
}

impl<R> StripWorkers<'_, '_, R> {
    /// Issues the command to finish, without waiting for the threads.
    fn stop_workers(&self) {
        self.board.command.store(Command::Finish as u64, Ordering::Relaxed);
        self.board.command_number.store(self.command_number + 1, Ordering::Release);
    }
}

impl<R> Drop for StripWorkers<'_, '_, R> {
    fn drop(&mut self) {
        if !self.others.is_empty() {
            self.stop_workers();
        }
    }
}

/// Reports the completed commands of a thread to the leader, and a panic if it is dropped before the last command.
struct WorkerGuard<'a> {
    last: &'a AtomicU64,
    has_finished: bool,
}

impl Drop for WorkerGuard<'_> {
    fn drop(&mut self) {
        if !self.has_finished {
            self.last.store(PANICKED, Ordering::Release);
        }
    }
}

/// Main loop of a thread other than the leader: executes commands on `strips`, the first of which has the number
/// `first`, until the command to finish; returns the strips.
fn run_worker<'a, R: Real>(
    board: &Board,
    thread: usize,
    first: usize,
    mut strips: Vec<Strip<'a, R>>,
) -> Vec<Strip<'a, R>> {
    let (mut command_number, mut step, mut patience) = (0, 0, Patience(Patience::MOST));
    let mut done = WorkerGuard { last: &board.done[thread], has_finished: false };
    loop {
        command_number += 1;
        patience.wait_until(|| board.command_number.load(Ordering::Acquire) >= command_number);
        let command = Command::ALL[board.command.load(Ordering::Relaxed) as usize];
        board.work(command, first, &mut strips, &mut step);
        done.last.store(command_number, Ordering::Release);
        if command == Command::Finish {
            done.has_finished = true;
            return strips;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::sync::mpsc;
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_thread_that_panics_ends_the_run_with_its_panic() {
        let (sender, receiver) = mpsc::channel();
        std::thread::spawn(move || {
            let found = catch_unwind(AssertUnwindSafe(|| {
                std::thread::scope(|scope| {
                    let board = Arc::new(Board::new::<f64>(&[], true, 2));
                    let others = (0..2).map(|thread| {
                        let board = Arc::clone(&board);
                        scope.spawn(move || run_worker::<f64>(&board, thread, 0, Vec::new()))
                    });
                    let others = others.collect();
                    let mut workers = StripWorkers {
                        board,
                        own: Vec::new(),
                        others,
                        patience: Patience(1),
                        command_number: 1,
                        step: 0,
                    };
                    // An invalid command: the threads panic when they look it up.
                    workers.board.command.store(Command::ALL.len() as u64, Ordering::Relaxed);
                    workers.board.command_number.store(1, Ordering::Release);
                    workers.wait_for_workers();
                });
            }));
            let _ = sender.send(found.map_err(|panic| panic.downcast_ref::<String>().cloned()));
        });
        let found = receiver.recv_timeout(Duration::from_secs(300)).unwrap();
        assert!(found.unwrap_err().is_some_and(|said| said.contains("out of bounds")));
    }
}
