//! The machines of a simulated cluster, and what messages cost on them.

use super::events::{Time, nanoseconds};

/// Nodes at one network. Values are those of a checked configuration.
#[derive(Clone, Debug, PartialEq)]
pub struct Cluster {
    pub nodes: Vec<Node>,
    pub master: MasterPlace,
    pub link: Link,
    pub messages: MessageCosts,
    pub copies: Copies,
    pub memory: MemoryRules,
}

/// What takes memory beside geometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MemoryRules {
    /// Of each process, without any geometry.
    pub process_bytes: f64,
    /// Clients are processes of the master's node until they have answered their first task, as
    /// those that Mosix has yet to move away (section 7.3 of the paper).
    pub begin_on_master: bool,
}

/// One computer. It has a worker for each core.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    pub cores: u32,
    /// Of a core: costs are those of a core of speed 1.
    pub speed: f64,
    pub memory_bytes: f64,
}

/// Where the master runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MasterPlace {
    /// On the first node, whose cores it shares with the workers there.
    FirstNode,
    /// On a computer of its own, which is as the first node.
    OwnNode,
}

/// What workers of one node have of the geometry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Copies {
    /// Each its own, as in the paper.
    Process,
    /// One in the node's shared memory.
    Node,
}

impl Copies {
    pub fn name(self) -> &'static str {
        match self {
            Self::Process => "process",
            Self::Node => "node",
        }
    }
}

/// The network: each node has one link to a switch, which is never the bottleneck. Both directions
/// of a link are independent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    pub bytes_per_s: f64,
    pub latency: Time,
    /// Bytes of headers that go with each message.
    pub message_bytes: f64,
    /// Of the sender, who waits until so many bytes are taken before sending more: the paper's
    /// pipes. Absent: messages are on their way without anybody waiting.
    pub window_bytes: Option<f64>,
}

impl Link {
    /// How long a message has the link for itself.
    pub fn occupied(&self, bytes: f64) -> Time {
        let windows = match self.window_bytes {
            None => 0.0,
            Some(window) => (bytes / window).ceil(),
        };
        let transfer = nanoseconds((bytes + self.message_bytes) / self.bytes_per_s);
        transfer + (windows * 2.0 * self.latency as f64) as Time
    }

    /// Whether the master waits for what it sends to be taken.
    pub fn is_blocking(&self) -> bool {
        self.window_bytes.is_some()
    }
}

/// Time on a core of speed 1 for each message, on both sides alike.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct MessageCosts {
    pub send: Time,
    pub receive: Time,
    /// Instead of `send` and `receive`, of each message that goes together with one before it.
    pub gathered: Time,
    /// Of the bytes of a message, by who sends it and by who receives it.
    pub copy_bytes_per_s: f64,
    /// Until a process that waits has woken up, in which nobody works.
    pub wake_up: Time,
    /// Of scoring a node, for each distributed root that the scenario needs, in nanoseconds.
    pub score_root: f64,
    /// Of delivering a result.
    pub delivery: Time,
}

impl MessageCosts {
    /// So many messages that go together.
    pub fn of_sending(&self, count: Time, bytes: f64) -> Time {
        self.send + self.of_contents(count, bytes)
    }

    pub fn of_receiving(&self, count: Time, bytes: f64) -> Time {
        self.receive + self.of_contents(count, bytes)
    }

    fn of_contents(&self, count: Time, bytes: f64) -> Time {
        count.saturating_sub(1) * self.gathered + nanoseconds(bytes / self.copy_bytes_per_s)
    }
}

impl Cluster {
    /// The node of each worker: those of one follow each other.
    pub fn worker_nodes(&self) -> Vec<usize> {
        let cores = self.nodes.iter().map(|node| node.cores as usize).enumerate();
        cores.flat_map(|(node, cores)| std::iter::repeat_n(node, cores)).collect()
    }

    /// Those of the workers, and the master's if it has one of its own.
    pub fn computers(&self) -> Vec<Node> {
        let own = (self.master == MasterPlace::OwnNode).then_some(self.nodes[0]);
        self.nodes.iter().copied().chain(own).collect()
    }

    /// Where the master is among them.
    pub fn master_node(&self) -> usize {
        match self.master {
            MasterPlace::FirstNode => 0,
            MasterPlace::OwnNode => self.nodes.len(),
        }
    }

    pub fn workers(&self) -> usize {
        self.nodes.iter().map(|node| node.cores as usize).sum()
    }

    /// The highest speedup over a core of the first node that there can be: n1 + n2 t1 / t2
    /// (section 7.1.1 of the paper).
    pub fn bound(&self) -> f64 {
        let cores = |node: &Node| f64::from(node.cores) * node.speed;
        self.nodes.iter().map(cores).sum::<f64>() / self.nodes[0].speed
    }

    /// Serial time on a core that stands for all, over that on a core of speed 1: weighted by how
    /// many there are of each (section 7.1 of the paper).
    pub fn weighted_time(&self) -> f64 {
        let time = |node: &Node| f64::from(node.cores) / node.speed;
        self.nodes.iter().map(time).sum::<f64>() / self.workers() as f64
    }

    /// Whether workers of the node read what the master itself has.
    pub fn is_in_place(&self, node: usize) -> bool {
        self.copies == Copies::Node && node == self.master_node()
    }

    /// Whether all workers do.
    pub fn is_all_in_place(&self) -> bool {
        self.nodes.len() == 1 && self.is_in_place(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paper's cluster, by table 2 for 20 % of the scenarios.
    #[test]
    fn the_bound_of_the_papers_cluster_is_25() {
        let node = |cores, speed| Node { cores, speed, memory_bytes: 3e9 };
        let nodes = [vec![node(4, 1.0); 5], vec![node(2, 281.0 / 452.0); 4]].concat();
        let link =
            Link { bytes_per_s: 125e6, latency: 50_000, message_bytes: 66.0, window_bytes: None };
        let messages = MessageCosts {
            send: 0,
            receive: 0,
            gathered: 0,
            copy_bytes_per_s: f64::INFINITY,
            wake_up: 0,
            score_root: 0.0,
            delivery: 0,
        };
        let (master, copies) = (MasterPlace::FirstNode, Copies::Process);
        let memory = MemoryRules { process_bytes: 0.0, begin_on_master: false };
        let cluster = Cluster { nodes, master, link, messages, copies, memory };
        assert_eq!(cluster.workers(), 28);
        assert!((cluster.bound() - 25.0).abs() < 0.05, "{}", cluster.bound());
        // Table 2: 281 and 452 seconds are 330 weighted.
        assert!((281.0 * cluster.weighted_time() - 330.0).abs() < 1.0);
    }

    #[test]
    fn who_waits_for_each_window_has_the_link_for_longer() {
        let link = Link { bytes_per_s: 1e9, latency: 10, message_bytes: 0.0, window_bytes: None };
        assert_eq!(link.occupied(1000.0), 1000);
        let waiting = Link { window_bytes: Some(400.0), ..link };
        assert_eq!(waiting.occupied(1000.0), 1000 + 3 * 2 * 10);
    }
}
