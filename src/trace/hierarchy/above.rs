//! The nodes above the chunks.

use glam::Vec3;

use super::slot::Slot;
use crate::base::convert::to_u32;
use crate::trace::slab::{Node, WIDTH};

/// Joins the roots of chunks, which lie in space as they lie in the list: its halves are apart, and so are their halves. A
/// node opens the largest of its halves until the node is full. Children come before their parents; `first` is the number
/// of the first node that is made here. `None` if there are no chunks.
pub(super) fn join(chunks: &[Slot], first: u32, nodes: &mut Vec<Node>) -> Option<Slot> {
    if let [] | [_] = chunks {
        return chunks.first().copied();
    }
    let area = |list: &[Slot]| {
        let (low, high) = bounds(list);
        let d = high - low;
        d.x * d.y + d.y * d.z + d.z * d.x
    };
    let mut children = vec![chunks];
    while children.len() < WIDTH {
        let open = children.iter().enumerate().filter(|(_, list)| list.len() > 1);
        let Some((widest, _)) = open.max_by(|a, b| area(a.1).total_cmp(&area(b.1))) else { break };
        let (left, right) = children[widest].split_at(children[widest].len() / 2);
        children[widest] = left;
        children.insert(widest + 1, right);
    }
    let mut node = Node::VACANT;
    for (i, list) in children.into_iter().enumerate() {
        node.set(i, &join(list, first, nodes)?);
    }
    nodes.push(node);
    let (low, high) = bounds(chunks);
    Some(Slot { low, high, child: first + to_u32(nodes.len()) - 1, count: 0 })
}

fn bounds(slots: &[Slot]) -> (Vec3, Vec3) {
    let start = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    slots.iter().fold(start, |(low, high), slot| (low.min(slot.low), high.max(slot.high)))
}
