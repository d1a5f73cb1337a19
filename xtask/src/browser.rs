//! A headless Chromium that is spoken to over pipes, by its debugging protocol.

use anyhow::{Context, Result, bail};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// Beginning of the address of a page that this machine serves.
pub(crate) const SERVED: &str = "http://127.0.0.1:";

/// One page in a browser of its own, which ends with it.
pub(crate) struct Browser {
    child: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
    profile: PathBuf,
    session: Option<String>,
    calls: u64,
    /// Beginning of the addresses that the page may ask for.
    own: String,
    /// Events of the page, such as messages on its console.
    pub(crate) events: Vec<Value>,
}

impl Browser {
    /// Starts a browser with an empty page, whose graphics are drawn by the processor.
    pub(crate) fn start(program: &Path) -> Result<Self> {
        let profile = std::env::temp_dir().join(format!("sinew-browser-{}", std::process::id()));
        // The protocol is spoken on descriptors 3 and 4.
        let mut child = Command::new("sh")
            .args(["-c", "exec \"$0\" \"$@\" 3<&0 4>&1 </dev/null >/dev/null 2>&1"])
            .arg(program)
            .args(["--headless=new", "--no-sandbox", "--remote-debugging-pipe"])
            .args(["--use-angle=swiftshader", "--enable-unsafe-swiftshader"])
            .arg(format!("--user-data-dir={}", profile.display()))
            .arg("about:blank")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        let to = child.stdin.take().context("no pipe to the browser")?;
        let from = BufReader::new(child.stdout.take().context("no pipe from the browser")?);
        let mut browser = Self {
            child,
            to,
            from,
            profile,
            session: None,
            calls: 0,
            own: String::new(),
            events: Vec::new(),
        };
        let page = browser.call("Target.createTarget", json!({ "url": "about:blank" }))?;
        let attach = json!({ "targetId": page["targetId"], "flatten": true });
        let attached = browser.call("Target.attachToTarget", attach)?;
        browser.session = attached["sessionId"].as_str().map(String::from);
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.call(&format!("{domain}.enable"), json!({}))?;
        }
        Ok(browser)
    }

    /// Calls a method of the protocol; its result.
    pub(crate) fn call(&mut self, method: &str, params: Value) -> Result<Value> {
        self.calls += 1;
        let mut message = json!({ "id": self.calls, "method": method, "params": params });
        if let Some(session) = &self.session {
            message["sessionId"] = json!(session);
        }
        self.to.write_all(message.to_string().as_bytes())?;
        self.to.write_all(&[0])?;
        self.to.flush()?;
        loop {
            let mut answer = self.read()?;
            if answer["id"] != json!(self.calls) {
                self.events.push(answer);
            } else if answer["error"].is_object() {
                bail!("{method}: {}", answer["error"]["message"]);
            } else {
                return Ok(answer["result"].take());
            }
        }
    }

    fn read(&mut self) -> Result<Value> {
        let mut bytes = Vec::new();
        self.from.read_until(0, &mut bytes)?;
        bytes.pop();
        serde_json::from_slice(&bytes)
            .context("the browser ended, or answered nothing that can be read")
    }

    /// Opens a file, or a page that this machine serves, in a window of some size and waits until it is loaded.
    pub(crate) fn open(&mut self, page: &Path, size: [u32; 2], dark: bool) -> Result<()> {
        let [width, height] = size;
        let metrics =
            json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", metrics)?;
        let scheme = if dark { "dark" } else { "light" };
        let media = json!({ "features": [{ "name": "prefers-color-scheme", "value": scheme }] });
        self.call("Emulation.setEmulatedMedia", media)?;
        self.events.clear();
        let served = page.to_str().filter(|page| page.starts_with(SERVED));
        let url = match served {
            Some(url) => url.to_string(),
            None => format!("file://{}", page.canonicalize()?.display()),
        };
        self.own = served.unwrap_or("file:").into();
        self.call("Page.navigate", json!({ "url": url }))?;
        while !self.events.iter().any(|event| event["method"] == "Page.loadEventFired") {
            let event = self.read()?;
            self.events.push(event);
        }
        Ok(())
    }

    /// Value of an expression of JavaScript, awaited if it is a promise.
    pub(crate) fn evaluate(&mut self, expression: &str) -> Result<Value> {
        let ask = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let mut found = self.call("Runtime.evaluate", ask)?;
        if found["exceptionDetails"].is_object() {
            bail!("{expression}: {}", found["exceptionDetails"]["exception"]["description"]);
        }
        Ok(found["result"]["value"].take())
    }

    /// Presses and releases a key on what has the focus.
    pub(crate) fn press(&mut self, key: &str, code: u32) -> Result<()> {
        for kind in ["rawKeyDown", "keyUp"] {
            let event = json!({ "type": kind, "key": key, "windowsVirtualKeyCode": code });
            self.call("Input.dispatchKeyEvent", event)?;
        }
        Ok(())
    }

    /// Errors on the console, and addresses other than the page's own that were asked for.
    pub(crate) fn faults(&self) -> Vec<String> {
        let fault = |event: &Value| {
            let (method, params) = (event["method"].as_str()?, &event["params"]);
            let told = match method {
                "Runtime.exceptionThrown" => {
                    &params["exceptionDetails"]["exception"]["description"]
                }
                "Runtime.consoleAPICalled" => &params["args"],
                "Log.entryAdded" => &params["entry"]["text"],
                "Network.requestWillBeSent" => &params["request"]["url"],
                _ => return None,
            };
            let own = method == "Network.requestWillBeSent"
                && told
                    .as_str()
                    .is_some_and(|url| url.starts_with(&self.own) || url.starts_with("data:"));
            (!own).then(|| format!("{method}: {told}"))
        };
        self.events.iter().filter_map(fault).collect()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // Nothing is left to be told about a browser that is gone already.
        let _ = self.child.kill();
        let _ = self.child.wait();
        let _ = std::fs::remove_dir_all(&self.profile);
    }
}
