//! HTTP/1.1 as far as clients of models need it: requests one after another on a connection, each within a time and a size.

use sinew::serve::Response;
use std::io::{Read, Write};
use std::net::{Shutdown, TcpStream};
use std::time::{Duration, Instant};

/// Largest content of a request \[bytes\].
const MOST_BYTES: usize = 1 << 20;
/// Largest head of a request \[bytes\].
const MOST_HEAD: usize = 16 << 10;
/// Time that a connection stays open between two requests.
const IDLE: Duration = Duration::from_secs(300);
/// Time for a client to read the last answer of a connection and to leave.
const LINGER: Duration = Duration::from_secs(1);

/// A request that has arrived.
pub(super) struct Request {
    pub(super) method: String,
    /// Path, without what follows a question mark.
    pub(super) path: String,
    pub(super) content: String,
    /// Whether the connection ends with the answer.
    pub(super) last: bool,
}

/// Reason of a missing request: an answer to what cannot be read, or none for a client that has left.
pub(super) type Refusal = Option<Response>;

/// A client.
pub(super) struct Connection {
    stream: TcpStream,
    /// Bytes that are read and not yet used.
    held: Vec<u8>,
    /// Time for a request to arrive.
    limit: Duration,
    /// End of the time for what is read now.
    until: Instant,
}

impl Connection {
    pub(super) fn new(stream: TcpStream, limit: Duration) -> Self {
        // Where a setting is refused answers come later, not wrong.
        let _ = stream.set_nodelay(true);
        let _ = stream.set_write_timeout(Some(limit));
        Self { stream, held: Vec::new(), limit, until: Instant::now() }
    }

    /// The next request.
    pub(super) fn request(&mut self) -> Result<Request, Refusal> {
        if self.held.is_empty() {
            self.until = Instant::now() + IDLE;
            self.more().map_err(|_| Refusal::None)?;
        }
        self.until = Instant::now() + self.limit;
        let head = self.text_to("\r\n\r\n")?;
        let mut lines = head.trim_start().split("\r\n");
        let words: Vec<&str> = lines.next().unwrap_or_default().split(' ').collect();
        let [method, target, version @ ("HTTP/1.0" | "HTTP/1.1")] = words[..] else {
            return Err(refused(400, "the request is not one of HTTP/1.1".into()));
        };
        let fields = lines.filter_map(|line| line.split_once(':'));
        let field = |name: &str| {
            let named = |(own, _): &(&str, &str)| own.trim().eq_ignore_ascii_case(name);
            fields.clone().find(named).map(|(_, value)| value.trim().to_ascii_lowercase())
        };
        if field("expect").is_some_and(|value| value == "100-continue") {
            self.stream.write_all(b"HTTP/1.1 100 Continue\r\n\r\n").map_err(|_| Refusal::None)?;
        }
        let content = match (field("transfer-encoding"), field("content-length")) {
            (Some(coding), _) if coding == "chunked" => self.chunks()?,
            (Some(coding), _) => {
                let reason = format!("the transfer encoding {coding} is not known here");
                return Err(refused(400, reason));
            }
            (None, Some(length)) => {
                let wrong = |_| refused(400, format!("{length} is not a length of content"));
                self.content(length.parse().map_err(wrong)?, 0)?
            }
            (None, None) => Vec::new(),
        };
        Ok(Request {
            method: method.into(),
            path: target.split('?').next().unwrap_or_default().into(),
            content: utf8(content)?,
            last: version == "HTTP/1.0" || field("connection").is_some_and(|it| it == "close"),
        })
    }

    /// Sends an answer, of a HEAD without its content; whether the connection goes on.
    pub(super) fn answer(&mut self, reply: &Response, is_head: bool, last: bool) -> bool {
        let Response { status, kind, text } = reply;
        let (length, goes_on) = (text.len(), if last { "close" } else { "keep-alive" });
        let content = if is_head { "" } else { text };
        let answer = format!(
            "HTTP/1.1 {status} \r\nContent-Type: {kind}\r\nContent-Length: {length}\r\nConnection: {goes_on}\r\n\r\n{content}"
        );
        let sent = self.stream.write_all(answer.as_bytes()).is_ok();
        if sent && last && self.stream.shutdown(Shutdown::Write).is_ok() {
            // A connection that is closed with bytes unread loses the answer.
            self.until = Instant::now() + LINGER;
            let _ = self.skip(usize::MAX);
        }
        sent && !last
    }

    /// Content in chunks of told lengths, to its end.
    fn chunks(&mut self) -> Result<Vec<u8>, Refusal> {
        let mut content = Vec::new();
        loop {
            let line = self.text_to("\r\n")?;
            let length = line.split(';').next().unwrap_or_default().trim();
            let wrong = |_| refused(400, format!("{length} is not a length of a chunk"));
            let length = usize::from_str_radix(length, 16).map_err(wrong)?;
            if length == 0 {
                while !self.text_to("\r\n")?.is_empty() {}
                return Ok(content);
            }
            content.extend(self.content(length, content.len())?);
            self.text_to("\r\n")?;
        }
    }

    /// Bytes of a content that has some already.
    fn content(&mut self, length: usize, before: usize) -> Result<Vec<u8>, Refusal> {
        if length > MOST_BYTES - before {
            let _ = self.skip(length);
            let reason =
                format!("the request is longer than {MOST_BYTES} bytes; send shorter ones");
            return Err(refused(413, reason));
        }
        while self.held.len() < length {
            self.more()?;
        }
        Ok(self.held.drain(..length).collect())
    }

    /// Text up to an end, without it.
    fn text_to(&mut self, end: &str) -> Result<String, Refusal> {
        loop {
            let found = self.held.windows(end.len()).position(|part| part == end.as_bytes());
            if let Some(length) = found {
                let text = self.held.drain(..length + end.len()).take(length).collect();
                return utf8(text);
            }
            if self.held.len() > MOST_HEAD {
                let reason = format!("the head of the request is longer than {MOST_HEAD} bytes");
                return Err(refused(431, reason));
            }
            self.more()?;
        }
    }

    /// Reads and drops bytes, so that a client that still sends them reads the answer.
    fn skip(&mut self, mut count: usize) -> Result<(), Refusal> {
        while count > 0 {
            if self.held.is_empty() {
                self.more()?;
            }
            let dropped = self.held.len().min(count);
            self.held.drain(..dropped);
            count -= dropped;
        }
        Ok(())
    }

    /// Reads on while there is time.
    fn more(&mut self) -> Result<(), Refusal> {
        let mut part = [0; 8192];
        let left = self.until.saturating_duration_since(Instant::now());
        // A time of nought is refused.
        let read =
            self.stream.set_read_timeout(Some(left)).and_then(|()| self.stream.read(&mut part));
        let seconds = self.limit.as_secs();
        let late = |_| refused(408, format!("the request did not arrive within {seconds} s"));
        match read.map_err(late)? {
            0 => Err(None),
            count => {
                self.held.extend(&part[..count]);
                Ok(())
            }
        }
    }
}

fn utf8(bytes: Vec<u8>) -> Result<String, Refusal> {
    String::from_utf8(bytes)
        .map_err(|error| refused(400, format!("the request is not UTF-8: {error}; send JSON")))
}

fn refused(status: u16, reason: String) -> Refusal {
    Some(Response::failed(status, "InvalidInput", &reason))
}
