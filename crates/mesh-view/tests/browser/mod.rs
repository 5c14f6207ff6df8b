//! Headless Chromium, controlled through its `DevTools` protocol, with only the functions that the tests need.
//!
//! The browser is Debian's `chromium`, or the program in the environment variable `CHROMIUM`. If there is none,
//! [`Browser::start`] prints that and returns `None`.
#![allow(
    dead_code,
    clippy::unwrap_used,
    clippy::panic,
    clippy::expect_used,
    clippy::print_stderr,
    clippy::needless_pass_by_value
)]

use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use base64::Engine;
use serde_json::{Value, json};
use tungstenite::{Message, WebSocket};

/// The time limit of any operation. Test machines are slow, and so is drawing without a graphics card.
const PATIENCE: Duration = Duration::from_secs(240);

/// A running browser with one page.
pub(crate) struct Browser {
    process: Child,
    socket: WebSocket<TcpStream>,
    session: Option<String>,
    last: u64,
    events: Vec<Value>,
    _profile: tempfile::TempDir,
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

impl Browser {
    /// Starts a browser with a window of this size. If that is impossible, prints the reason and returns `None`.
    pub(crate) fn start(size: [u32; 2]) -> Option<Self> {
        let program = std::env::var("CHROMIUM").unwrap_or_else(|_| "chromium".to_owned());
        let profile = tempfile::tempdir().unwrap();
        let started = Command::new(&program)
            .args([
                "--headless",
                "--no-sandbox",
                "--disable-gpu",
                "--use-angle=swiftshader",
                "--enable-unsafe-swiftshader",
                "--disable-quic",
                "--no-first-run",
                "--disable-background-networking",
                "--disable-component-update",
                "--disable-sync",
                "--disable-dev-shm-usage",
                "--remote-debugging-port=0",
            ])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg("about:blank")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn();
        let mut process = match started {
            Ok(process) => process,
            Err(error) => {
                eprintln!("skipped: {program} cannot be started ({error}); install chromium");
                return None;
            }
        };
        let errors = BufReader::new(process.stderr.take().unwrap());
        let (sender, receiver) = std::sync::mpsc::channel();
        // The pipe must be read to its end, or the browser would block.
        std::thread::spawn(move || {
            for line in errors.lines().map_while(Result::ok) {
                let _ = sender.send(line);
            }
        });
        let address = loop {
            let line = receiver.recv_timeout(PATIENCE).expect("the browser says where it listens");
            if let Some((_, address)) = line.split_once("DevTools listening on ") {
                break address.to_owned();
            }
        };
        let host = address.trim_start_matches("ws://").split('/').next().unwrap();
        let stream = TcpStream::connect(host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let (socket, _) = tungstenite::client(address.as_str(), stream).unwrap();
        let mut browser =
            Self { process, socket, session: None, last: 0, events: Vec::new(), _profile: profile };
        let targets = browser.call("Target.getTargets", json!({}));
        let targets = targets["targetInfos"].as_array().unwrap();
        let page = targets.iter().find(|t| t["type"] == "page").unwrap()["targetId"].clone();
        let attach = json!({ "targetId": page, "flatten": true });
        let session = browser.call("Target.attachToTarget", attach)["sessionId"].clone();
        browser.session = Some(session.as_str().unwrap().to_owned());
        for domain in ["Page", "Runtime", "Network", "Log"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        browser.resize(size);
        Some(browser)
    }

    /// Changes the size of the window.
    pub(crate) fn resize(&mut self, [width, height]: [u32; 2]) {
        let metrics =
            json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", metrics);
    }

    /// Calls a method of the protocol.
    pub(crate) fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.last += 1;
        let mut message = json!({ "id": self.last, "method": method, "params": parameters });
        if let Some(session) = &self.session {
            message["sessionId"] = json!(session);
        }
        self.socket.send(Message::text(message.to_string())).unwrap();
        loop {
            let Message::Text(text) = self.socket.read().unwrap() else { continue };
            let mut answer: Value = serde_json::from_str(&text).unwrap();
            if answer["id"] == self.last {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].take();
            }
            self.events.push(answer);
        }
    }

    /// The value of an expression; waits for promises.
    pub(crate) fn eval(&mut self, expression: &str) -> Value {
        let parameters =
            json!({ "expression": expression, "awaitPromise": true, "returnByValue": true });
        let mut answer = self.call("Runtime.evaluate", parameters);
        assert!(
            answer["exceptionDetails"].is_null(),
            "{expression}: {}",
            answer["exceptionDetails"]
        );
        answer["result"]["value"].take()
    }

    /// The numeric value of an expression.
    pub(crate) fn number(&mut self, expression: &str) -> f64 {
        let value = self.eval(expression);
        value.as_f64().unwrap_or_else(|| panic!("{expression} is {value}"))
    }

    /// The text value of an expression.
    pub(crate) fn text(&mut self, expression: &str) -> String {
        let value = self.eval(expression);
        value.as_str().unwrap_or_else(|| panic!("{expression} is {value}")).to_owned()
    }

    /// Waits until an expression is true.
    pub(crate) fn wait_for(&mut self, expression: &str) {
        let start = Instant::now();
        while self.eval(expression) != true {
            assert!(start.elapsed() < PATIENCE, "{expression} does not become true");
            std::thread::sleep(Duration::from_millis(40));
        }
    }

    /// Opens a file and waits until an expression is true.
    pub(crate) fn open(&mut self, path: &Path, ready: &str) {
        self.events.clear();
        let path = path.canonicalize().unwrap();
        self.call("Page.navigate", json!({ "url": format!("file://{}", path.display()) }));
        self.wait_for("document.readyState === 'complete'");
        self.wait_for(ready);
    }

    /// Opens a page of this crate, waits for its first picture, and gives the keys to it.
    pub(crate) fn open_view(&mut self, path: &Path) {
        self.open(path, "Boolean(window.curvmesh && (curvmesh.ready || curvmesh.error))");
        assert_eq!(self.eval("curvmesh.error"), Value::Null);
        self.eval("document.getElementById('canvas').focus(); 1");
    }

    /// Waits until all requested drawing is done.
    pub(crate) fn settle(&mut self) {
        self.eval("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))");
    }

    /// Presses and releases a key, named as in [`KeyboardEvent.key`].
    pub(crate) fn press(&mut self, key: &str) {
        for kind in ["keyDown", "keyUp"] {
            let mut event = json!({ "type": kind, "key": key });
            let text = match key {
                "Enter" => "\r",
                _ => key,
            };
            if kind == "keyDown" && text.chars().count() == 1 {
                event["text"] = json!(text);
            }
            event["windowsVirtualKeyCode"] = json!(match key {
                "Tab" => 9,
                "Enter" => 13,
                " " => 32,
                "ArrowLeft" => 37,
                "ArrowUp" => 38,
                "ArrowRight" => 39,
                "ArrowDown" => 40,
                _ => i64::from(key.to_ascii_uppercase().as_bytes()[0]),
            });
            self.call("Input.dispatchKeyEvent", event);
        }
        self.settle();
    }

    /// Moves the pointer, with its left button down if `down`.
    pub(crate) fn mouse(&mut self, kind: &str, [x, y]: [f64; 2], down: bool) {
        let button = if down || kind != "mouseMoved" { "left" } else { "none" };
        let event = json!({
            "type": kind, "x": x, "y": y, "button": button, "buttons": i32::from(down),
            "clickCount": 1,
        });
        self.call("Input.dispatchMouseEvent", event);
    }

    /// Drags with the left button.
    pub(crate) fn drag(&mut self, from: [f64; 2], to: [f64; 2]) {
        self.mouse("mousePressed", from, true);
        for step in 1..=4 {
            let t = f64::from(step) / 4.0;
            self.mouse("mouseMoved", [0, 1].map(|i| from[i] + t * (to[i] - from[i])), true);
        }
        self.mouse("mouseReleased", to, false);
        self.settle();
    }

    /// Sets a control as a user would: its value, and the event for the page.
    pub(crate) fn set(&mut self, id: &str, value: &str) {
        let (id, value) = (json!(id), json!(value));
        self.eval(&format!(
            "{{ const c = document.getElementById({id});
               if (c.type === 'checkbox') {{ if (c.checked !== ({value} === 'on')) c.click(); }}
               else {{ c.value = {value}; c.dispatchEvent(new Event('input', {{ bubbles: true }}));
                 c.dispatchEvent(new Event('change', {{ bubbles: true }})); }} 1 }}"
        ));
        self.settle();
    }

    /// The pixels of a part of the window: width, height, and RGBA row by row.
    pub(crate) fn picture(&mut self, clip: Option<[f64; 4]>) -> Pixels {
        let mut parameters = json!({ "format": "png" });
        if let Some([x, y, width, height]) = clip {
            parameters["clip"] =
                json!({ "x": x, "y": y, "width": width, "height": height, "scale": 1 });
        }
        let answer = self.call("Page.captureScreenshot", parameters);
        let data = answer["data"].as_str().unwrap();
        let png = base64::engine::general_purpose::STANDARD.decode(data).unwrap();
        let image = image::load_from_memory(&png).unwrap().to_rgba8();
        let (width, height) = image.dimensions();
        Pixels { width, height, rgba: image.into_raw(), png }
    }

    /// The pixels of the canvas.
    pub(crate) fn canvas(&mut self) -> Pixels {
        let clip = self.eval(
            "(() => { const r = document.getElementById('canvas').getBoundingClientRect(); return [r.x, r.y, r.width, r.height]; })()",
        );
        let clip: Vec<f64> = serde_json::from_value(clip).unwrap();
        self.picture(Some([clip[0], clip[1], clip[2], clip[3]]))
    }

    /// Messages of the page on the console, errors, and requests other than for the page itself.
    pub(crate) fn complaints(&mut self) -> Vec<String> {
        self.eval("1");
        let mut found = Vec::new();
        for event in &self.events {
            let parameters = &event["params"];
            match event["method"].as_str() {
                Some("Runtime.consoleAPICalled") => found.push(parameters["args"].to_string()),
                Some("Runtime.exceptionThrown") => found.push(parameters.to_string()),
                Some("Log.entryAdded") => {
                    let text = parameters["entry"]["text"].to_string();
                    // Reading the object under the pointer waits for the GPU, which the browser reports.
                    if !text.contains("GPU stall due to ReadPixels") {
                        found.push(text);
                    }
                }
                Some("Network.requestWillBeSent") => {
                    let url = parameters["request"]["url"].as_str().unwrap_or_default();
                    // A blob is memory of the page, such as a saved picture.
                    if parameters["type"] != "Document" && !url.starts_with("blob:") {
                        found.push(format!("request for {url}"));
                    }
                }
                _ => {}
            }
        }
        found
    }
}

/// A picture of the window.
pub(crate) struct Pixels {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) rgba: Vec<u8>,
    pub(crate) png: Vec<u8>,
}

impl Pixels {
    /// The share of pixels that differ noticeably from another picture.
    pub(crate) fn difference(&self, other: &Self) -> f64 {
        assert_eq!((self.width, self.height), (other.width, other.height));
        let pairs = self.rgba.chunks(4).zip(other.rgba.chunks(4));
        let differing = pairs.filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 12));
        differing.count() as f64 / f64::from(self.width * self.height)
    }

    /// A part of the picture.
    pub(crate) fn part(&self, [x, y, width, height]: [u32; 4]) -> Self {
        let row = |row: u32| {
            let start = 4 * (row * self.width + x) as usize;
            &self.rgba[start..start + 4 * width as usize]
        };
        let rgba = (y..y + height).flat_map(row).copied().collect();
        Self { width, height, rgba, png: Vec::new() }
    }

    /// The share of pixels that are not nearly white.
    pub(crate) fn inked(&self) -> f64 {
        let dark = self.rgba.chunks(4).filter(|p| p[..3].iter().any(|&c| c < 235)).count();
        dark as f64 / f64::from(self.width * self.height)
    }

    /// The number of clearly different colours.
    pub(crate) fn colors(&self) -> usize {
        let all: std::collections::HashSet<[u8; 3]> =
            self.rgba.chunks(4).map(|p| [p[0] >> 4, p[1] >> 4, p[2] >> 4]).collect();
        all.len()
    }

    /// Saves the picture for inspection, if the variable `CURVMESH_SHOTS` names a folder.
    pub(crate) fn keep(&self, name: &str) {
        if let Some(folder) = std::env::var_os("CURVMESH_SHOTS") {
            let _ = std::fs::create_dir_all(&folder);
            std::fs::write(Path::new(&folder).join(name), &self.png).unwrap();
        }
    }
}
