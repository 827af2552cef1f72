//! A preview of a render in the image viewer tev, while it lasts.
//!
//! tev listens on TCP for packets (tev, `src/python/ipc.py`): the length of the packet in bytes including
//! these four, its kind, and its fields; integers little-endian, texts ended by a zero. Of its kinds two are
//! needed: *create image* (4) and *update image*, version 3 (6).

use super::passes::Partial;
use crate::film::Window;
use std::io::{self, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

const CREATE_IMAGE: u8 = 4;
const UPDATE_IMAGE: u8 = 6;

/// Rows in one packet.
const ROWS: usize = 64;

/// How long a viewer may take to answer, and for the last frame, before it is given up.
const PATIENCE: Duration = Duration::from_secs(3);

/// A connection to a viewer. Nothing that happens to it can stop a render, or hold it up for longer than
/// three seconds: a viewer that is slower than the passes misses some of them.
pub struct Preview {
    /// Those that are shown while there is room, and the last.
    frames: Sender<Vec<f32>>,
    /// Whether there is room for a frame.
    free: Arc<AtomicBool>,
    /// How the connection ended.
    end: Receiver<io::Result<()>>,
}

impl Preview {
    /// Connects to `address`, such as `localhost:14158`, and creates an image of the film's size.
    ///
    /// # Errors
    /// If nobody answers there.
    pub fn connect(
        address: &str,
        name: &str,
        film: (u32, u32),
        window: Window,
        channels: &[String],
    ) -> io::Result<Preview> {
        let mut failure = io::Error::new(io::ErrorKind::NotFound, "no such host");
        let mut stream = None;
        for place in address.to_socket_addrs()? {
            match TcpStream::connect_timeout(&place, PATIENCE) {
                Ok(connected) => {
                    stream = Some(connected);
                    break;
                }
                Err(error) => failure = error,
            }
        }
        let mut stream = stream.ok_or(failure)?;
        stream.set_write_timeout(Some(PATIENCE))?;
        stream.write_all(&create(name, film, channels))?;
        let (frames, arriving) = channel::<Vec<f32>>();
        let (ends, end) = channel();
        let (name, channels) = (name.to_owned(), channels.to_vec());
        let free = Arc::new(AtomicBool::new(true));
        let taken = free.clone();
        let serve = move || {
            for frame in arriving {
                taken.store(true, Ordering::Relaxed);
                for top in (0..window.height as usize).step_by(ROWS) {
                    let rows = ROWS.min(window.height as usize - top);
                    stream.write_all(&update(&name, &channels, window, top..top + rows, &frame))?;
                }
            }
            stream.flush()
        };
        std::thread::spawn(move || ends.send(serve()));
        Ok(Preview { frames, free, end })
    }

    /// Shows a render, unless the viewer is busy with the last one.
    pub fn show(&self, partial: &Partial) {
        if self.free.swap(false, Ordering::Relaxed) {
            // The next pass comes soon, and `finish` tells of a viewer that is gone.
            let _ = self.frames.send(means(partial));
        }
    }

    /// Shows the end of a render, and waits until it has arrived, or its time is over.
    ///
    /// # Errors
    /// If the viewer had gone away at some time, or is too slow.
    pub fn finish(self, partial: &Partial) -> io::Result<()> {
        // It fails if the thread has ended already, and then that says why.
        let _ = self.frames.send(means(partial));
        drop(self.frames);
        match self.end.recv_timeout(PATIENCE) {
            // What a system calls a write that was not taken in time.
            Ok(Err(error)) if error.kind() == io::ErrorKind::WouldBlock => Err(too_slow()),
            Ok(end) => end,
            Err(RecvTimeoutError::Timeout) => Err(too_slow()),
            Err(RecvTimeoutError::Disconnected) => Err(io::Error::other("the preview failed")),
        }
    }
}

fn too_slow() -> io::Error {
    let seconds = PATIENCE.as_secs();
    io::Error::new(io::ErrorKind::TimedOut, format!("the viewer took nothing for {seconds} s"))
}

/// The image so far, channel by channel.
fn means(partial: &Partial) -> Vec<f32> {
    let samples = partial.samples.end - partial.samples.start;
    let channels = 0..partial.channels.len();
    channels.flat_map(|c| partial.sums.channel(c).map(|sum| sum.mean(samples) as f32)).collect()
}

/// The fields of a packet.
struct Packet(Vec<u8>);

impl Packet {
    fn new(kind: u8, name: &str) -> Self {
        // The length is known at the end; the viewer need not bring the image to the front (0).
        let mut packet = Self(vec![0, 0, 0, 0, kind, 0]);
        packet.text(name);
        packet
    }

    fn text(&mut self, text: &str) {
        self.0.extend(text.bytes().filter(|&byte| byte != 0));
        self.0.push(0);
    }

    fn integer(&mut self, value: usize) {
        self.0.extend((value as i32).to_le_bytes());
    }

    fn long(&mut self, value: usize) {
        self.0.extend((value as i64).to_le_bytes());
    }

    fn finish(mut self) -> Vec<u8> {
        let length = (self.0.len() as u32).to_le_bytes();
        self.0[..4].copy_from_slice(&length);
        self.0
    }
}

fn create(name: &str, (width, height): (u32, u32), channels: &[String]) -> Vec<u8> {
    let mut packet = Packet::new(CREATE_IMAGE, name);
    packet.integer(width as usize);
    packet.integer(height as usize);
    packet.integer(channels.len());
    channels.iter().for_each(|channel| packet.text(channel));
    packet.finish()
}

/// Some rows of a frame. Channels follow each other, so the values of one are at an offset and with a stride
/// of 1.
fn update(
    name: &str,
    channels: &[String],
    window: Window,
    rows: std::ops::Range<usize>,
    frame: &[f32],
) -> Vec<u8> {
    let width = window.width as usize;
    let mut packet = Packet::new(UPDATE_IMAGE, name);
    packet.integer(channels.len());
    channels.iter().for_each(|channel| packet.text(channel));
    for value in [window.x as usize, window.y as usize + rows.start, width, rows.len()] {
        packet.integer(value);
    }
    (0..channels.len()).for_each(|c| packet.long(c * width * rows.len()));
    channels.iter().for_each(|_| packet.long(1));
    for plane in frame.chunks_exact(window.pixels()) {
        for value in &plane[rows.start * width..rows.end * width] {
            packet.0.extend(value.to_le_bytes());
        }
    }
    packet.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Accumulators;
    use crate::render::Report;
    use crate::render::light_path_noise::LightPathNoise;
    use std::io::Read;
    use std::net::TcpListener;

    const WINDOW: Window = Window { x: 2, y: 3, width: 5, height: 70 };

    fn partial() -> Partial {
        let mut sums = Accumulators::new(WINDOW.width, WINDOW.height, 2);
        for (y, x) in (0..WINDOW.height).flat_map(|y| (0..WINDOW.width).map(move |x| (y, x))) {
            for (c, sum) in sums.pixel_mut(x, y).iter_mut().enumerate() {
                sum.add(0, f64::from(1000 * c as u32 + 10 * y + x));
            }
        }
        Partial {
            samples: 0..1,
            channels: vec!["R".into(), "λ".into()],
            sums,
            report: Report::default(),
            history: None,
            light_paths: LightPathNoise::default(),
        }
    }

    /// Takes fields off the front of a packet.
    struct Fields<'a>(&'a [u8]);

    impl Fields<'_> {
        fn take<const N: usize>(&mut self) -> [u8; N] {
            let (head, rest) = self.0.split_first_chunk().expect("a field");
            self.0 = rest;
            *head
        }

        fn integer(&mut self) -> i32 {
            i32::from_le_bytes(self.take())
        }

        fn text(&mut self) -> String {
            let end = self.0.iter().position(|&b| b == 0).expect("an end");
            let text = String::from_utf8(self.0[..end].to_vec()).expect("UTF-8");
            self.0 = &self.0[end + 1..];
            text
        }
    }

    #[test]
    fn a_viewer_receives_the_image() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("an address").to_string();
        let viewer = std::thread::spawn(move || {
            let mut received = vec![];
            listener.accept().expect("a guest").0.read_to_end(&mut received).map(|_| received)
        });
        let partial = partial();
        let preview = Preview::connect(&address, "out.exr", (20, 80), WINDOW, &partial.channels);
        preview.and_then(|preview| preview.finish(&partial)).expect("it is shown");
        let received = viewer.join().expect("it ends").expect("read");
        let (mut rest, mut packets) = (&received[..], vec![]);
        while !rest.is_empty() {
            let length = Fields(rest).integer() as usize;
            packets.push(Fields(&rest[4..length]));
            rest = &rest[length..];
        }
        let mut image = packets.remove(0);
        assert_eq!((image.take(), image.text()), ([4, 0], "out.exr".into()));
        assert_eq!([image.integer(), image.integer(), image.integer()], [20, 80, 2]);
        assert_eq!((image.text(), image.text(), image.0.len()), ("R".into(), "λ".into(), 0));
        assert_eq!(packets.len(), 2);
        for (mut rows, (top, height)) in packets.into_iter().zip([(0, 64), (64, 6)]) {
            assert_eq!((rows.take(), rows.text(), rows.integer()), ([6, 0], "out.exr".into(), 2));
            assert_eq!((rows.text(), rows.text()), ("R".into(), "λ".into()));
            let place = [rows.integer(), rows.integer(), rows.integer(), rows.integer()];
            assert_eq!(place, [2, 3 + top, 5, height]);
            let layout = [rows.take(), rows.take(), rows.take(), rows.take()].map(i64::from_le_bytes);
            assert_eq!(layout, [0, 5 * i64::from(height), 1, 1]);
            for (c, y) in (0..2).flat_map(|c| (top..top + height).map(move |y| (c, y))) {
                for x in 0..5 {
                    assert_eq!(f32::from_le_bytes(rows.take()), (1000 * c + 10 * y + x) as f32);
                }
            }
            assert!(rows.0.is_empty());
        }
    }

    #[test]
    fn a_viewer_that_is_gone_is_an_error_and_nothing_worse() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("an address").to_string();
        let partial = partial();
        let preview =
            Preview::connect(&address, "a", (20, 80), WINDOW, &partial.channels).expect("connected");
        drop(listener);
        // The system notices with the second packet at the latest.
        (0..100).for_each(|_| preview.show(&partial));
        assert!(preview.finish(&partial).is_err());
        assert!(Preview::connect(&address, "a", (20, 80), WINDOW, &partial.channels).is_err());
        assert!(Preview::connect("nonsense", "a", (20, 80), WINDOW, &partial.channels).is_err());
    }
}
