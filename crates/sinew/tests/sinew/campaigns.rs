//! Campaigns by a Slurm that is really there, two nodes of one machine on loopback without systemd.

use crate::program::{bar, done, table};
use std::fs::{self, File};
use std::io::Read;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Time that the campaign may take \[s\].
const MOST_SECONDS: f64 = 90.0;
const SHARDS: usize = 16;

/// File of a daemon; Slurm and Munge put theirs where a user's PATH may not look.
fn daemon(name: &str) -> PathBuf {
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let known = ["/usr/sbin", "/usr/local/sbin"].map(PathBuf::from);
    let mut all = std::env::split_paths(&folders).chain(known).map(|folder| folder.join(name));
    all.find(|file| file.is_file()).unwrap_or_else(|| panic!("there is no {name} on this machine"))
}

/// Daemons of a cluster of two nodes, which end with it.
struct Cluster {
    folder: PathBuf,
    daemons: Vec<(&'static str, Child)>,
}

impl Cluster {
    /// A cluster with its files in `folder`.
    fn start(folder: &Path) -> Self {
        let [munged, slurmctld, slurmd] = ["munged", "slurmctld", "slurmd"].map(daemon);
        let mut cluster = Self { folder: folder.into(), daemons: Vec::new() };
        cluster.configure();
        let at = |name: &str| folder.join(name).display().to_string();
        let files = [
            ("key-file", "key"),
            ("socket", "socket"),
            ("pid-file", "munged.pid"),
            ("log-file", "munged.log"),
            ("seed-file", "seed"),
        ];
        let files: Vec<_> =
            files.iter().map(|(key, file)| format!("--{key}={}", at(file))).collect();
        cluster.spawn("munged", Command::new(munged).args(["--foreground", "--force"]).args(files));
        cluster.spawn("slurmctld", Command::new(slurmctld).args(["-D", "-c"]));
        for node in ["n1", "n2"] {
            cluster.spawn(node, Command::new(&slurmd).args(["-D", "-N", node]));
        }
        cluster
            .wait("two idle nodes", 60, || cluster.said("sinfo", "-h -o %T=%D").trim() == "idle=2");
        cluster
    }

    fn configure(&self) {
        let mut key = [0; 64];
        File::open("/dev/urandom").unwrap().read_exact(&mut key).unwrap();
        fs::write(self.folder.join("key"), key).unwrap();
        Command::new("chmod").arg("400").arg(self.folder.join("key")).status().unwrap();
        let word = |program: &str, option: &str| {
            let output = Command::new(program).arg(option).output().unwrap().stdout;
            String::from_utf8(output).unwrap().trim().to_string()
        };
        let (host, user) = (word("hostname", "-s"), word("id", "-un"));
        // Ports that are free now, held together so that they differ.
        let held = [(); 3].map(|()| TcpListener::bind("127.0.0.1:0").unwrap());
        let [control, one, two] = held.each_ref().map(|port| port.local_addr().unwrap().port());
        let folder = self.folder.display();
        let text = format!(
            "ClusterName=sinew\nSlurmctldHost={host}(127.0.0.1)\nSlurmctldPort={control}\nSlurmUser={user}\nSlurmdUser={user}\n\
             AuthType=auth/munge\nCredType=cred/munge\nAuthInfo=socket={folder}/socket,cred_expire=5\n\
             SlurmctldPidFile={folder}/slurmctld.pid\nSlurmdPidFile={folder}/%n.pid\nSlurmdSpoolDir={folder}/spool-%n\n\
             StateSaveLocation={folder}/state\nSlurmctldLogFile={folder}/slurmctld.log\nSlurmdLogFile={folder}/%n.log\n\
             ProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nSwitchType=switch/none\nMpiDefault=none\n\
             ReturnToService=2\nSlurmdTimeout=5\nKillWait=5\nJobRequeue=1\nSelectType=select/cons_tres\n\
             SelectTypeParameters=CR_Core\nSchedulerParameters=batch_sched_delay=1,sched_interval=2\n\
             AccountingStorageType=accounting_storage/none\nJobAcctGatherType=jobacct_gather/none\nJobCompType=jobcomp/none\n\
             NodeName=n1 NodeHostname={host} NodeAddr=127.0.0.1 Port={one} CPUs=2 RealMemory=500\n\
             NodeName=n2 NodeHostname={host} NodeAddr=127.0.0.1 Port={two} CPUs=2 RealMemory=500\n\
             PartitionName=main Nodes=n1,n2 Default=YES State=UP\n"
        );
        fs::write(self.folder.join("slurm.conf"), text).unwrap();
        fs::create_dir(self.folder.join("state")).unwrap();
    }

    fn spawn(&mut self, name: &'static str, command: &mut Command) {
        let log = File::create(self.folder.join(format!("{name}.out"))).unwrap();
        command.env("SLURM_CONF", self.folder.join("slurm.conf")).stdin(Stdio::null());
        self.daemons.push((name, command.stdout(Stdio::null()).stderr(log).spawn().unwrap()));
    }

    /// A client's command in the folder above, where the case is, with the program `sinew` at hand.
    fn client(&self, program: &str) -> Command {
        let mut command = with_sinew(program);
        command.env("SLURM_CONF", self.folder.join("slurm.conf"));
        command.current_dir(self.folder.parent().unwrap());
        command
    }

    /// Output of a client's command, empty where it fails.
    fn said(&self, program: &str, arguments: &str) -> String {
        let output = self.client(program).args(arguments.split_whitespace()).output().unwrap();
        if output.status.success() {
            String::from_utf8(output.stdout).unwrap()
        } else {
            String::new()
        }
    }

    /// Waits until something holds; fails after so many seconds with what the controller wrote.
    fn wait(&self, what: &str, seconds: u64, holds: impl Fn() -> bool) {
        let start = Instant::now();
        while !holds() {
            if start.elapsed() > Duration::from_secs(seconds) {
                let log = fs::read_to_string(self.folder.join("slurmctld.log")).unwrap_or_default();
                let lines: Vec<_> = log.lines().rev().take(30).collect();
                let queue = self.said("squeue", "-r");
                panic!("no {what} after {seconds} s\n{queue}\n{}", lines.join("\n"));
            }
            std::thread::sleep(Duration::from_millis(200));
        }
    }

    /// Jobs on a node, or on all: processes whose environment names this cluster, and the steps of Slurm that started them.
    fn jobs(&self, node: Option<&str>) -> Vec<Process> {
        let own = format!("SLURM_CONF={}", self.folder.join("slurm.conf").display());
        let name = format!("SLURMD_NODENAME={}", node.unwrap_or_default());
        let is_there =
            |pair: &str| if node.is_some() { pair == name } else { pair.starts_with(&name) };
        let mut found = Vec::new();
        for entry in fs::read_dir("/proc").unwrap().flatten() {
            let Ok(environment) = fs::read(entry.path().join("environ")) else { continue };
            let environment = String::from_utf8_lossy(&environment).into_owned();
            let pairs = || environment.split('\0');
            if !(pairs().any(|pair| pair == own) && pairs().any(is_there)) {
                continue;
            }
            let stat = fs::read_to_string(entry.path().join("stat")).unwrap_or_default();
            let parent = stat.rsplit(')').next().and_then(|rest| rest.split_whitespace().nth(1));
            let own = Process::of(&entry.file_name().to_string_lossy());
            let parent = Process::of(parent.unwrap_or_default());
            found.extend(Some(parent).filter(|parent| parent.name.starts_with("slurmstepd")));
            found.push(own);
        }
        found
    }

    /// A node that loses its power: its daemon and all that runs there, at once.
    fn kill_node(&mut self, node: &'static str) -> Vec<Process> {
        let victims = self.jobs(Some(node));
        let place = self.daemons.iter().position(|(name, _)| *name == node).unwrap();
        let mut daemon = self.daemons.remove(place).1;
        daemon.kill().unwrap();
        kill_all(&victims);
        daemon.wait().unwrap();
        victims
    }
}

/// A process of a job.
struct Process {
    id: String,
    name: String,
}

impl Process {
    fn of(id: &str) -> Self {
        let name = fs::read_to_string(format!("/proc/{id}/comm")).unwrap_or_default();
        Self { id: id.into(), name: name.trim().into() }
    }
}

fn kill_all(processes: &[Process]) {
    if !processes.is_empty() {
        let ids = processes.iter().map(|process| &process.id);
        Command::new("kill").arg("-KILL").args(ids).output().unwrap();
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        kill_all(&self.jobs(None));
        for (_, daemon) in self.daemons.iter_mut().rev() {
            let _ = Command::new("kill").arg(daemon.id().to_string()).status();
            std::thread::sleep(Duration::from_millis(100));
            let _ = daemon.kill();
            let _ = daemon.wait();
        }
    }
}

#[test]
#[ignore = "starts a Slurm for a minute: cargo xtask campaigns"]
fn a_campaign_on_slurm_survives_a_requeue_and_a_dead_node() {
    let folder = bar();
    let folder = folder.path();
    let slurm = folder.join("slurm");
    fs::create_dir(&slurm).unwrap();
    let mut cluster = Cluster::start(&slurm);
    let start = Instant::now();
    let case =
        fs::read_to_string(folder.join("bar.toml")).unwrap().replace("[6, 2, 2]", "[30, 6, 6]");
    fs::write(folder.join("bar.toml"), case).unwrap();
    let options = "--count 192 --design sobol";
    let told = done(
        folder,
        &format!("sample bar.toml {options} --out parts --script slurm --shards {SHARDS}"),
    );
    assert!(told.contains("sh parts/sample/slurm.sh"), "{told}");
    let told = cluster.said("sh", "parts/sample/slurm.sh --mem=50");
    let array =
        told.lines().find_map(|line| line.strip_prefix("Submitted array job ")).expect(&told);
    // Tasks that count from nought.
    let line =
        "sinew sample bar.toml --count 6 --solve --out auto --shard $((SLURM_ARRAY_TASK_ID + 1))/2";
    cluster.client("sbatch").args(["--array=0-1", "--mem=50", "--wrap", line]).output().unwrap();

    let running =
        |node: &str| cluster.said("squeue", &format!("-h -r -t R -w {node} -j {array} -o %K"));
    let solves =
        |node: &str| cluster.jobs(Some(node)).iter().any(|process| process.name == "sinew");
    cluster.wait("solves on both nodes", 60, || solves("n1") && solves("n2"));
    let task = running("n1").lines().next().unwrap().to_string();
    cluster.said("scontrol", &format!("requeue {array}_{task}"));
    let lost: Vec<_> = running("n2").lines().map(str::to_string).collect();
    let victims = cluster.kill_node("n2");
    let victims: Vec<_> = victims.iter().map(|process| process.name.as_str()).collect();
    eprintln!(
        "task {task} requeued; node n2 killed with tasks {} ({})",
        lost.join(", "),
        victims.join(" ")
    );
    assert!(victims.contains(&"sinew") && !lost.is_empty());
    let log = folder.join(format!("parts/sample/slurm-{array}_{task}.log"));

    cluster.wait("merged tables", MOST_SECONDS as u64, || {
        folder.join("parts/sample/cases.csv").exists()
    });
    let controller = fs::read_to_string(slurm.join("slurmctld.log")).unwrap();
    assert!(controller.contains("n2 not responding") || controller.contains("n2 set DOWN"));
    cluster.wait("an empty queue", 60, || cluster.said("squeue", "-h -r").is_empty());
    let seconds = start.elapsed().as_secs_f64();
    drop(cluster);
    // The requeued task was stopped by SIGTERM, and stored what it had.
    let log = fs::read_to_string(log).unwrap();
    assert!(log.contains("with everything stored"), "{log}");

    done(folder, &format!("sample bar.toml {options} --solve --out whole"));
    let apart = apart(folder);
    eprintln!(
        "{SHARDS} shards on Slurm in {seconds:.0} s; merged tables and those of one process: {apart:.1e} apart"
    );
    assert!(apart <= 1e-10, "{apart}");
    assert!(done(folder, "merge bar.toml --out auto").contains("6 of 6 samples solved"));
    assert!(seconds <= MOST_SECONDS, "{seconds}");
}

/// A command that finds the program `sinew`.
fn with_sinew(program: &str) -> Command {
    let own = Path::new(env!("CARGO_BIN_EXE_sinew")).parent().unwrap().to_path_buf();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths(std::iter::once(own).chain(std::env::split_paths(&path)));
    let mut command = Command::new(program);
    command.env("PATH", path.unwrap());
    command
}

/// Largest relative difference between the merged tables and those of one process.
fn apart(folder: &Path) -> f64 {
    let [parts, whole] =
        ["parts", "whole"].map(|run| table(&folder.join(run).join("sample/cases.csv")));
    assert!(parts.len() == whole.len() && !whole.is_empty());
    parts.iter().zip(&whole).map(|(a, b)| (a - b).abs() / b.abs()).fold(0.0, f64::max)
}
