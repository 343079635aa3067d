//! The scripts of `data-scripts/` against a server of this machine. They need `python3` on the path, and a machine
//! that runs scripts by their first line.
#![cfg(unix)]

mod program;

use std::fs;
use std::io::{BufRead, BufReader, Cursor, Write};
use std::net::{TcpListener, TcpStream};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::{Arc, Mutex};

use mesotex::btf::Sample;
use mesotex::btf::fits::{Basis, Colors, Fit, ptm};
use mesotex::format::npy;
use ndarray::Array5;
use zip::write::SimpleFileOptions;

/// What the server has, and what was asked of it.
struct State {
    bytes: Vec<u8>,
    version: &'static str,
    /// Bytes after which the next answer is cut off.
    cut: Option<usize>,
    /// The first line and the range of each request.
    requests: Vec<String>,
}

/// A server that has one file under every name.
struct Server {
    port: u16,
    state: Arc<Mutex<State>>,
}

impl Server {
    fn start(bytes: Vec<u8>) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let state = Arc::new(Mutex::new(State {
            bytes,
            version: "\"1\"",
            cut: None,
            requests: Vec::new(),
        }));
        let shared = Arc::clone(&state);
        std::thread::spawn(move || {
            for stream in listener.incoming() {
                answer(stream.unwrap(), &mut shared.lock().unwrap());
            }
        });
        Self { port, state }
    }

    fn address(&self, name: &str) -> String {
        format!("http://127.0.0.1:{}/data/{name}", self.port)
    }

    fn requests(&self) -> Vec<String> {
        std::mem::take(&mut self.state.lock().unwrap().requests)
    }
}

fn answer(mut stream: TcpStream, state: &mut State) {
    let mut lines = BufReader::new(&stream).lines().map(|line| line.unwrap());
    let first = lines.next().unwrap();
    let headers: Vec<String> = lines.take_while(|line| !line.is_empty()).collect();
    let header = |name: &str| {
        let find = |line: &String| {
            let (key, value) = line.split_once(": ")?;
            key.eq_ignore_ascii_case(name).then(|| value.to_owned())
        };
        headers.iter().find_map(find)
    };
    let range = header("Range").filter(|_| header("If-Range").as_deref() == Some(state.version));
    state
        .requests
        .push(format!("{first} {}", header("Range").unwrap_or_default()));
    let from = range.as_deref().map_or(0, |range| {
        range
            .trim_start_matches("bytes=")
            .trim_end_matches('-')
            .parse()
            .unwrap()
    });
    let status = if range.is_some() {
        "206 Partial Content"
    } else {
        "200 OK"
    };
    let body = &state.bytes[from..];
    let sent = state
        .cut
        .take()
        .map_or(body.len(), |cut| cut.min(body.len()));
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Length: {}\r\nETag: {}\r\nConnection: close\r\n\r\n",
        body.len(),
        state.version
    )
    .unwrap();
    stream.write_all(&body[..sent]).unwrap();
}

fn run(folder: &Path, script: &str, words: &[&str]) -> Output {
    let scripts = Path::new(env!("CARGO_MANIFEST_DIR")).join("data-scripts");
    let mut command = Command::new("python3");
    command
        .arg("-B")
        .arg(scripts.join(script))
        .args(words)
        .current_dir(folder);
    command
        .output()
        .expect("python3 runs the scripts of data-scripts")
}

fn succeed(folder: &Path, script: &str, words: &[&str]) -> String {
    let output = run(folder, script, words);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success(),
        "{script} {words:?} failed:\n{error}"
    );
    String::from_utf8(output.stdout).unwrap()
}

fn refuse(folder: &Path, script: &str, words: &[&str]) -> String {
    let output = run(folder, script, words);
    assert_eq!(output.status.code(), Some(1), "{script} {words:?}");
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!error.contains("Traceback"), "{error}");
    error
}

/// A program that notes the words it is called with.
fn note_taker(folder: &Path) -> String {
    let path = folder.join("noting");
    fs::write(&path, "#!/bin/sh\necho \"$@\" > noted\n").unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn every_script_fetches_and_converts() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(b"PTM or anything else".to_vec());
    let program = note_taker(folder.path());
    for (script, words, file, noted) in [
        (
            "fetch_ubo2003.py",
            "IMPALLA",
            "UBO.zip",
            "import UBO.zip -o impalla.sample",
        ),
        (
            "fetch_atrium.py",
            "CEILING",
            "a.zip",
            "import a.zip -o ceiling.sample",
        ),
        (
            "fetch_utia.py",
            "wool",
            "wool.zip",
            "import wool.zip -o wool.sample",
        ),
        (
            "fetch_ubo2014.py",
            "felt05",
            "felt.btf",
            "import felt.btf -o felt05.sample",
        ),
        (
            "fetch_spectral.py",
            "red",
            "red.zip",
            "import red.zip -o red.sample",
        ),
        (
            "fetch_curet.py",
            "7",
            "sample07.zip",
            "import sample07.zip -o curet07.sample",
        ),
        (
            "fetch_rti.py",
            "coin",
            "coin.ptm",
            "import coin.ptm -o coin.sample --lights bonn81",
        ),
    ] {
        let address = server.address(file);
        let words = [words, "--address", &address, "--mesotex", &program];
        let told = succeed(folder.path(), script, &words);
        assert!(told.contains("terms"), "{script} states no terms: {told}");
        let found = fs::read_to_string(folder.path().join("noted")).unwrap();
        assert_eq!(found.trim_end(), noted, "{script}");
        assert_eq!(server.requests(), [format!("GET /data/{file} HTTP/1.1 ")]);
        // What is there is not fetched again.
        assert!(succeed(folder.path(), script, &words).contains("there already"));
        assert_eq!(server.requests(), Vec::<String>::new());
    }
}

#[test]
fn cut_downloads_go_on() {
    let folder = tempfile::tempdir().unwrap();
    let bytes: Vec<u8> = (0..3_000_000u32).map(|k| (k * 7 % 251) as u8).collect();
    let server = Server::start(bytes.clone());
    server.state.lock().unwrap().cut = Some(2_000_000);
    let address = server.address("felt.btf");
    let words = [
        "felt05",
        "--address",
        &address,
        "--only-fetch",
        "--into",
        "data",
    ];
    let error = refuse(folder.path(), "fetch_ubo2014.py", &words);
    assert!(
        error.contains("2000000 of 3000000") && error.contains("is kept"),
        "{error}"
    );
    assert!(!folder.path().join("data/felt.btf").exists());
    succeed(folder.path(), "fetch_ubo2014.py", &words);
    let requests = server.requests();
    assert!(requests[1].ends_with(" bytes=2000000-"), "{requests:?}");
    assert_eq!(
        fs::read(folder.path().join("data/felt.btf")).unwrap(),
        bytes
    );
    assert_eq!(fs::read_dir(folder.path().join("data")).unwrap().count(), 1);
}

#[test]
fn another_file_under_the_name_is_begun_anew() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(vec![1; 5000]);
    server.state.lock().unwrap().cut = Some(3000);
    let address = server.address("felt.btf");
    let words = ["felt05", "--address", &address, "--only-fetch"];
    refuse(folder.path(), "fetch_ubo2014.py", &words);
    {
        let mut state = server.state.lock().unwrap();
        (state.bytes, state.version) = (vec![2; 4000], "\"2\"");
    }
    succeed(folder.path(), "fetch_ubo2014.py", &words);
    assert_eq!(
        fs::read(folder.path().join("felt.btf")).unwrap(),
        vec![2; 4000]
    );
}

#[test]
fn files_of_another_size_or_hash_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(b"abc".to_vec());
    let address = server.address("a.zip");
    let known = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
    let with = |option, value| ["x", "--address", &address, "--only-fetch", option, value];
    let error = refuse(folder.path(), "fetch_utia.py", &with("--size", "4"));
    assert!(error.contains("3 bytes; expected 4"), "{error}");
    let other = known.replace("ba78", "0000");
    let error = refuse(folder.path(), "fetch_utia.py", &with("--sha256", &other));
    assert!(error.contains(known) && error.contains("a.zip"), "{error}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    succeed(folder.path(), "fetch_utia.py", &with("--sha256", known));
    let error = refuse(folder.path(), "fetch_utia.py", &with("--size", "4"));
    assert!(error.contains("expected 4"), "{error}");
    assert!(folder.path().join("a.zip").exists());
}

#[test]
fn what_cannot_be_fetched_is_told_without_a_trace() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(Vec::new());
    let error = refuse(folder.path(), "fetch_curet.py", &["62"]);
    assert!(error.contains("1 to 61"), "{error}");
    refuse(folder.path(), "fetch_ubo2014.py", &["felt"]);
    let address = server.address("");
    let error = refuse(
        folder.path(),
        "fetch_utia.py",
        &["x", "--address", &address],
    );
    assert!(error.contains("no file's name"), "{error}");
    let closed = TcpListener::bind("127.0.0.1:0")
        .unwrap()
        .local_addr()
        .unwrap();
    let address = format!("http://{closed}/a.zip");
    let error = refuse(
        folder.path(),
        "fetch_utia.py",
        &["x", "--address", &address],
    );
    assert!(error.contains("a.zip"), "{error}");
}

/// A small fit as a `.ptm` file.
fn ptm_bytes(folder: &Path) -> Vec<u8> {
    let fit = Fit {
        width: 4,
        height: 3,
        basis: Basis::Polynomial,
        colors: Colors::Lrgb,
        scale: vec![1.0; 6],
        offset: vec![-100.0, -100.0, -100.0, -100.0, -100.0, 0.0],
        coefficients: (0..72).map(|k| 90 + k as u8).collect(),
        texel_colors: vec![200; 36],
        white: 255.0,
    };
    let path = folder.join("made.ptm");
    ptm::write(&path, &fit).unwrap();
    fs::read(path).unwrap()
}

/// The files of a folder as a zip archive, below a folder of their own.
fn zip_of(folder: &Path) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in program::files(folder) {
        let name = format!("capture/{}", name.display());
        archive
            .start_file(name, SimpleFileOptions::default())
            .unwrap();
        archive.write_all(&bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// What `mesotex export` makes of a small sample, as bytes: a file, or the zip archive of a folder.
fn exported(folder: &Path, format: &str) -> Vec<u8> {
    let words = "import felt.npy --views rings:0:1,30:3 --lights rings:15:2,60:4 -o felt.sample";
    let shape = (4, 6, 5, 7, 3);
    let numbers = Array5::from_shape_fn(shape, |(v, l, h, w, c)| (v + l + h + w + c) as f32 * 0.03);
    npy::write(&folder.join("felt.npy"), numbers.view().into_dyn()).unwrap();
    program::succeed(folder, &words.split(' ').collect::<Vec<_>>());
    program::succeed(
        folder,
        &["export", "felt.sample", "--to", format, "-o", format],
    );
    let out = folder.join(format);
    match out.is_dir() {
        true => zip_of(&out),
        false => fs::read(out).unwrap(),
    }
}

#[test]
fn examples_become_samples() {
    let (folder, beside) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let program = env!("CARGO_BIN_EXE_mesotex");
    program::write_capture(&beside.path().join("capture"));
    let capture = zip_of(&beside.path().join("capture"));
    let of = |format| exported(beside.path(), format);
    let lights = &["--lights", "fibonacci:9"][..];
    for (script, name, file, bytes, words, images) in [
        (
            "fetch_rti.py",
            "coin",
            "coin.ptm",
            ptm_bytes(beside.path()),
            lights,
            9,
        ),
        (
            "fetch_rti.py",
            "dome",
            "dome.zip",
            capture.clone(),
            lights,
            5,
        ),
        (
            "fetch_ubo2003.py",
            "felt",
            "UBO_FELT.zip",
            of("ubo2003"),
            &[],
            24,
        ),
        ("fetch_utia.py", "wool", "wool.zip", of("utia"), &[], 24),
        (
            "fetch_ubo2014.py",
            "felt05",
            "felt05.btf",
            of("bdi"),
            &[],
            24,
        ),
    ] {
        let address = Server::start(bytes).address(file);
        let fixed = [name, "--address", &address, "--mesotex", program];
        succeed(folder.path(), script, &[&fixed[..], words].concat());
        let sample = Sample::open(&folder.path().join(format!("{name}.sample"))).unwrap();
        assert_eq!(sample.image_count(), images, "{script}");
    }
    // Directions that a table states.
    let mut table =
        String::from("file,view_theta_deg,view_phi_deg,light_theta_deg,light_phi_deg\n");
    (0..5).for_each(|image| table += &format!("{image}.png,0,0,40,{}\n", 72 * image));
    let address = Server::start(capture).address("tvBTF09.zip");
    let words = ["tvBTF09", "--address", &address, "--mesotex", program];
    let told = succeed(folder.path(), "fetch_staf.py", &words);
    assert!(told.contains("write a table"), "{told}");
    let path = folder.path().join("tvBTF09/capture/step.csv");
    fs::write(&path, table).unwrap();
    let with_table = [&words[..], &["--table", path.to_str().unwrap()]].concat();
    succeed(folder.path(), "fetch_staf.py", &with_table);
    let sample = Sample::open(&folder.path().join("tvBTF09.sample")).unwrap();
    assert_eq!(sample.image_count(), 5);
}
