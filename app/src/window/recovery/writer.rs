//! The thread that writes journals and autosaves, so that no step waits for a disk.

use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use lorelei_core::document;
use lorelei_core::groom::Groom;
use lorelei_core::record::{self, Record};

use super::{Header, remove, restore};

/// How long a record may wait to be synced to the disk.
const SYNC_INTERVAL: Duration = Duration::from_secs(2);

pub(super) enum Message {
    /// A new journal; those before it are written on until its autosave is there.
    Begin {
        number: u32,
        header: Header,
    },
    Append(Vec<Record>),
    /// Nothing more goes to the journals that are open.
    Close,
    Autosave {
        number: u32,
        groom: Box<Groom>,
        replaces: Vec<PathBuf>,
    },
    Autosaved {
        number: u32,
        saved: Result<(), String>,
        replaces: Vec<PathBuf>,
    },
    /// Files with numbers before this are not needed any more.
    Forget {
        before: u32,
    },
    Finish,
}

/// A handle of the thread.
pub(super) struct Writer {
    sender: mpsc::Sender<Message>,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Shared {
    /// Of the newest journal.
    n_bytes: AtomicU64,
    n_records: AtomicU64,
    problem: Mutex<Option<String>>,
}

impl Writer {
    pub fn start(folder: &Path) -> std::io::Result<Self> {
        let (sender, receiver) = mpsc::channel();
        let shared = Arc::new(Shared::default());
        let thread = Journals {
            folder: folder.to_owned(),
            open: Vec::new(),
            oldest: 0,
            n_saving: 0,
            sender: sender.clone(),
            shared: Arc::clone(&shared),
            last_sync: Instant::now(),
            is_dirty: false,
        };
        let run = move || thread.run(&receiver);
        let thread = Some(std::thread::Builder::new().name("journal".to_owned()).spawn(run)?);
        Ok(Self { sender, shared, thread })
    }

    pub fn send(&self, message: Message) {
        // It ends only after `finish`.
        let _ = self.sender.send(message);
    }

    pub fn n_bytes(&self) -> u64 {
        self.shared.n_bytes.load(Ordering::Relaxed)
    }

    pub fn n_records(&self) -> u64 {
        self.shared.n_records.load(Ordering::Relaxed)
    }

    pub fn problem(&self) -> Option<String> {
        self.shared.problem.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Do what was asked for, then end.
    pub fn finish(&mut self) {
        self.send(Message::Finish);
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            log::error!("the journal's thread ended badly");
        }
    }
}

struct Journal {
    number: u32,
    file: File,
}

/// What the thread has.
struct Journals {
    folder: PathBuf,
    /// Records go to all of them, oldest first.
    open: Vec<Journal>,
    /// The lowest number that is still needed.
    oldest: u32,
    /// Autosaves that are being written.
    n_saving: u32,
    sender: mpsc::Sender<Message>,
    shared: Arc<Shared>,
    last_sync: Instant,
    is_dirty: bool,
}

impl Journals {
    fn run(mut self, receiver: &mpsc::Receiver<Message>) {
        let mut is_finishing = false;
        loop {
            let message = match receiver.recv_timeout(SYNC_INTERVAL) {
                Ok(message) => Some(message),
                Err(mpsc::RecvTimeoutError::Timeout) => None,
                Err(mpsc::RecvTimeoutError::Disconnected) => return,
            };
            match message {
                Some(Message::Begin { number, header }) => self.begin(number, &header),
                Some(Message::Append(records)) => self.append(&records),
                Some(Message::Close) => self.open.clear(),
                Some(Message::Autosave { number, groom, replaces }) => self.autosave(number, groom, replaces),
                Some(Message::Autosaved { number, saved, replaces }) => self.autosaved(number, saved, &replaces),
                Some(Message::Forget { before }) => self.forget(before),
                Some(Message::Finish) => is_finishing = true,
                None => {}
            }
            if self.is_dirty && self.last_sync.elapsed() >= SYNC_INTERVAL || is_finishing {
                self.sync();
            }
            // An autosave that comes too late is removed, so it is waited for.
            if is_finishing && self.n_saving == 0 {
                return;
            }
        }
    }

    fn begin(&mut self, number: u32, header: &Header) {
        let path = restore::journal_file(&self.folder, std::process::id(), number);
        let made = OpenOptions::new().write(true).create(true).truncate(true).open(&path).and_then(|mut file| {
            let text = ron::to_string(header).map_err(std::io::Error::other)?;
            file.write_all(format!("{text}\n").as_bytes())?;
            Ok(file)
        });
        self.shared.n_bytes.store(0, Ordering::Relaxed);
        match made {
            Ok(file) => self.open.push(Journal { number, file }),
            Err(why) => self.tell(&path, &why),
        }
        self.is_dirty = true;
    }

    fn append(&mut self, records: &[Record]) {
        let mut lines = Vec::new();
        for record in records {
            if let Err(why) = record::write_line(&mut lines, record) {
                // Not replayable beyond this: the next autosave has it.
                log::error!("`{}` cannot be written: {why}", record.label);
                self.open.clear();
                return;
            }
        }
        let mut failed = None;
        self.open.retain_mut(|journal| match journal.file.write_all(&lines) {
            Ok(()) => true,
            Err(why) => {
                failed = Some((journal.number, why));
                false
            }
        });
        if let Some((number, why)) = failed {
            self.tell(&restore::journal_file(&self.folder, std::process::id(), number), &why);
        }
        self.shared.n_bytes.fetch_add(lines.len() as u64, Ordering::Relaxed);
        self.shared.n_records.fetch_add(records.len() as u64, Ordering::Relaxed);
        self.is_dirty = true;
    }

    fn autosave(&mut self, number: u32, groom: Box<Groom>, replaces: Vec<PathBuf>) {
        let (sender, path) = (self.sender.clone(), restore::autosave_file(&self.folder, std::process::id(), number));
        self.n_saving += 1;
        std::thread::spawn(move || {
            let saved = document::save(&groom, &path).map_err(|why| why.to_string());
            // The studio may be gone meanwhile.
            let _ = sender.send(Message::Autosaved { number, saved, replaces });
        });
    }

    fn autosaved(&mut self, number: u32, saved: Result<(), String>, replaces: &[PathBuf]) {
        self.n_saving -= 1;
        match saved {
            Ok(()) => {
                for file in replaces {
                    remove(file);
                }
                if number < self.oldest {
                    self.remove(number);
                } else {
                    self.forget(number);
                }
            }
            Err(why) => {
                // What is before it goes on being the base.
                self.open.retain(|journal| journal.number != number);
                self.remove(number);
                self.tell(&self.folder.clone(), &why);
            }
        }
    }

    fn forget(&mut self, before: u32) {
        self.open.retain(|journal| journal.number >= before);
        (self.oldest..before).for_each(|number| self.remove(number));
        self.oldest = self.oldest.max(before);
        if self.open.is_empty() {
            self.shared.n_bytes.store(0, Ordering::Relaxed);
        }
    }

    fn remove(&self, number: u32) {
        let id = std::process::id();
        remove(&restore::journal_file(&self.folder, id, number));
        remove(&restore::autosave_file(&self.folder, id, number));
    }

    fn sync(&mut self) {
        for journal in &self.open {
            if let Err(why) = journal.file.sync_data() {
                log::warn!("a journal was not synced: {why}");
            }
        }
        self.is_dirty = false;
        self.last_sync = Instant::now();
    }

    fn tell(&self, path: &Path, why: &dyn std::fmt::Display) {
        log::warn!("{}: {why}", path.display());
        let problem = format!("{}: {why}. Save the groom; free some space on that disk", path.display());
        *self.shared.problem.lock().unwrap_or_else(PoisonError::into_inner) = Some(problem);
    }
}
