//! A Chromium without a window, driven by its WebDriver.

use crate::Outcome;
use fantoccini::wd::{Capabilities, WebDriverCompatibleCommand};
use fantoccini::{Client, ClientBuilder};
use serde_json::{Value, json};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Time that anything the page does may take on a loaded machine.
pub(crate) const PATIENCE: Duration = Duration::from_secs(90);

/// The driver's process, on a port of its own.
#[derive(Debug)]
pub(crate) struct Driver {
    process: std::sync::Mutex<Child>,
    port: u16,
}

impl Drop for Driver {
    fn drop(&mut self) {
        if let Ok(process) = self.process.get_mut() {
            // It may have ended by itself.
            let _ = process.kill();
            let _ = process.wait();
        }
    }
}

/// A program in the search path.
fn program(names: &[&str]) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    names
        .iter()
        .find_map(|name| std::env::split_paths(&path).map(|folder| folder.join(name)).find(|p| p.is_file()))
}

/// Starts the driver; none where Chromium or its driver is not installed.
pub(crate) fn driver() -> Outcome<Option<Driver>> {
    let Some(driver) = program(&["chromedriver"]) else { return Ok(None) };
    if program(&["chromium", "chromium-browser", "google-chrome"]).is_none() {
        return Ok(None);
    }
    let port = TcpListener::bind("127.0.0.1:0")
        .and_then(|l| l.local_addr())
        .map_err(|e| format!("no port: {e}"))?
        .port();
    let process = Command::new(driver)
        .arg(format!("--port={port}"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .map_err(|e| format!("the driver did not start: {e}"))?;
    let driver = Driver { process: std::sync::Mutex::new(process), port };
    let began = Instant::now();
    while TcpStream::connect(("127.0.0.1", port)).is_err() {
        if began.elapsed() > PATIENCE {
            return Err("the driver does not answer".to_owned());
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    Ok(Some(driver))
}

/// A page in the browser.
pub(crate) struct Browser {
    pub(crate) client: Client,
}

/// A command of Chromium's own driver: the end of its address, and what it is given.
#[derive(Debug)]
struct Own(&'static str, Value);

impl WebDriverCompatibleCommand for Own {
    fn endpoint(&self, base: &url::Url, session: Option<&str>) -> Result<url::Url, url::ParseError> {
        base.join(&format!("session/{}/{}", session.unwrap_or_default(), self.0))
    }

    fn method_and_body(&self, _: &url::Url) -> (http::Method, Option<String>) {
        (http::Method::POST, Some(self.1.to_string()))
    }
}

impl Browser {
    /// Opens a browser without a page.
    pub(crate) async fn open(driver: &Driver) -> Outcome<Self> {
        let binary = program(&["chromium", "chromium-browser", "google-chrome"]).unwrap_or_default();
        let options = json!({"binary": binary, "args": ["--headless=new", "--no-sandbox", "--disable-dev-shm-usage",
            "--enable-unsafe-swiftshader", "--use-angle=swiftshader", "--ignore-gpu-blocklist", "--hide-scrollbars",
            "--enable-precise-memory-info", "--js-flags=--expose-gc", "--window-size=1400,900"]});
        let mut capabilities = Capabilities::new();
        capabilities.insert("goog:chromeOptions".to_owned(), options);
        capabilities.insert("goog:loggingPrefs".to_owned(), json!({"browser": "ALL"}));
        let client = ClientBuilder::new(connector())
            .capabilities(capabilities)
            .connect(&format!("http://127.0.0.1:{}", driver.port))
            .await
            .map_err(|e| format!("no session with the browser: {e}"))?;
        Ok(Self { client })
    }

    pub(crate) async fn close(&self) {
        // The driver ends the browser with itself, too.
        let _ = self.client.clone().close().await;
    }

    pub(crate) async fn go(&self, address: &str) -> Outcome<()> {
        self.client.goto(address).await.map_err(|e| format!("{address}: {e}"))
    }

    /// Size of the page, px; a narrow one is that of a phone.
    pub(crate) async fn size(&self, width: u32, height: u32) -> Outcome<()> {
        let params = json!({"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600});
        let command =
            Own("goog/cdp/execute", json!({"cmd": "Emulation.setDeviceMetricsOverride", "params": params}));
        self.client.issue_cmd(command).await.map_err(|e| format!("size of the page: {e}"))?;
        Ok(())
    }

    /// What a script returns.
    pub(crate) async fn value(&self, script: &str) -> Outcome<Value> {
        self.client.execute(script, Vec::new()).await.map_err(|e| format!("`{script}`: {e}"))
    }

    /// A number that a script returns.
    pub(crate) async fn number(&self, script: &str) -> Outcome<f64> {
        self.value(script).await?.as_f64().ok_or(format!("`{script}` is no number"))
    }

    /// What a script hands to its last argument, a function.
    pub(crate) async fn later(&self, script: &str) -> Outcome<Value> {
        self.client.execute_async(script, Vec::new()).await.map_err(|e| format!("`{script}`: {e}"))
    }

    /// Waits for an expression to hold, and tells how long it took.
    pub(crate) async fn until(&self, what: &str, expression: &str) -> Outcome<Duration> {
        let began = Instant::now();
        while self.value(&format!("return Boolean({expression})")).await? != Value::Bool(true) {
            if began.elapsed() > PATIENCE {
                return Err(format!("{what}: `{expression}` did not hold within {} s", PATIENCE.as_secs()));
            }
            rest(20).await;
        }
        Ok(began.elapsed())
    }

    /// Errors that the page's console has shown since the last call.
    pub(crate) async fn console_errors(&self) -> Outcome<Vec<String>> {
        let log = self
            .client
            .issue_cmd(Own("se/log", json!({"type": "browser"})))
            .await
            .map_err(|e| format!("the console: {e}"))?;
        let severe = log.as_array().into_iter().flatten().filter(|entry| entry["level"] == "SEVERE");
        Ok(severe.map(|entry| entry["message"].as_str().unwrap_or_default().to_owned()).collect())
    }

    /// Saves a picture of the page.
    pub(crate) async fn picture(&self, folder: &Path, name: &str) -> Outcome<()> {
        let bytes = self.client.screenshot().await.map_err(|e| format!("screenshot {name}: {e}"))?;
        let file = folder.join(format!("{name}.png"));
        std::fs::write(&file, bytes).map_err(|e| format!("{}: {e}", file.display()))
    }
}

/// Plain HTTP: the driver is on this machine.
fn connector() -> hyper_util::client::legacy::connect::HttpConnector {
    hyper_util::client::legacy::connect::HttpConnector::new()
}

pub(crate) async fn rest(milliseconds: u64) {
    tokio::time::sleep(Duration::from_millis(milliseconds)).await;
}
