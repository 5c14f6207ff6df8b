//! Divides a number of faces among meshes, so that the next collapse of each costs about the same.

/// The collapses of a mesh, in order.
#[derive(Clone, Debug)]
pub(super) struct Collapses {
    /// The number of times that the mesh is drawn.
    pub(super) times: usize,
    /// The number of faces before the first collapse.
    pub(super) faces: usize,
    /// The mesh keeps at least this many faces.
    pub(super) least: usize,
    /// The cost of each collapse where the mesh is drawn, and the number of faces after it.
    pub(super) steps: Vec<(f64, usize)>,
}

/// The numbers of faces of meshes that are drawn with at most `budget` faces: the collapses of all meshes are merged, as
/// if one queue had them all, up to the one that reaches the budget. If all collapses do not suffice, all of them count.
pub(super) fn split(all: &[Collapses], budget: usize) -> Vec<usize> {
    let mut faces: Vec<usize> = all.iter().map(|mesh| mesh.faces).collect();
    let mut drawn: usize = all.iter().map(|mesh| mesh.times * mesh.faces).sum();
    let mut queue: Vec<(f64, usize, usize)> = Vec::new();
    for (place, mesh) in all.iter().enumerate() {
        let mut largest = 0.0_f64;
        let allowed = mesh.steps.iter().take_while(|(_, left)| *left >= mesh.least);
        queue.extend(allowed.map(|&(cost, left)| {
            // A collapse waits for the ones before it.
            largest = largest.max(cost);
            (largest, place, left)
        }));
    }
    // The sort is stable, so the collapses of a mesh stay in order.
    queue.sort_by(|(a, ..), (b, ..)| a.total_cmp(b));
    for (_, place, left) in queue {
        if drawn <= budget {
            break;
        }
        drawn -= all[place].times * (faces[place] - left);
        faces[place] = left;
    }
    faces
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Collapses whose costs rise and fall, each of one or two faces.
    fn collapses(times: usize, count: usize, next: &mut impl FnMut(u32) -> u32) -> Collapses {
        let faces = 2 * count + 4;
        let mut left = faces;
        let mut unique = f64::from(next(1000)) * 1e-9;
        let mut step = |_| {
            left -= 1 + next(2) as usize;
            // Costs that differ leave no choice.
            unique += 1e-6;
            (f64::from(next(50)) + unique, left)
        };
        Collapses { times, faces, least: 0, steps: (0..count).map(&mut step).collect() }
    }

    /// One queue, which takes the cheapest of the next collapses.
    fn one_by_one(all: &[Collapses], budget: usize) -> Vec<usize> {
        let mut done = vec![0; all.len()];
        let faces = |done: &[usize], i: usize| match done[i] {
            0 => all[i].faces,
            count => all[i].steps[count - 1].1,
        };
        loop {
            let found: Vec<usize> = (0..all.len()).map(|i| faces(&done, i)).collect();
            let drawn: usize = found.iter().zip(all).map(|(faces, one)| faces * one.times).sum();
            let next = |i: &usize| all[*i].steps.get(done[*i]).map(|step| (step.0, *i));
            let cheapest = (0..all.len())
                .filter_map(|i| next(&i))
                .reduce(|a, b| if b.0 < a.0 { b } else { a });
            match cheapest {
                Some((_, i)) if drawn > budget => done[i] += 1,
                _ => return found,
            }
        }
    }

    #[test]
    fn the_split_is_that_of_one_queue() {
        let mut random = 5_u64;
        let mut next = |below: u32| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (random >> 33) as u32 % below
        };
        for _ in 0..200 {
            let all: Vec<Collapses> = (0..1 + next(4))
                .map(|_| collapses(1 + next(3) as usize, next(30) as usize, &mut next))
                .collect();
            let total: usize = all.iter().map(|one| one.times * one.faces).sum();
            for budget in [0, total / 3, total / 2, total - 1, total, 2 * total] {
                let (found, expected) = (split(&all, budget), one_by_one(&all, budget));
                let drawn = |faces: &[usize]| -> usize {
                    faces.iter().zip(&all).map(|(faces, one)| faces * one.times).sum()
                };
                assert!(drawn(&found) <= budget || budget < drawn(&one_by_one(&all, 0)));
                assert_eq!(found, expected);
            }
        }
    }
}
