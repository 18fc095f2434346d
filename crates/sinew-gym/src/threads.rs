use rayon::{ThreadPool, ThreadPoolBuilder};
use sinew::Error;
use std::sync::{Mutex, PoisonError};

/// Threads that share a list of independent items, the calling one among them.
#[derive(Debug)]
pub(crate) struct Threads {
    /// The others; none where the calling thread is alone.
    others: Option<ThreadPool>,
}

/// Most threads.
const MOST: usize = 1024;
/// Most worlds of a batch.
const MOST_WORLDS: usize = 1_000_000;

/// Refuses no worlds, and too many.
pub(crate) fn check_worlds(name: &'static str, count: usize) -> Result<(), Error> {
    let (expected, got) = ("from 1 to 1 000 000", count as f64);
    if (1..=MOST_WORLDS).contains(&count) { Ok(()) } else { Err(Error::OutOfDomain { name, expected, got }) }
}

impl Threads {
    /// `count` in all; not more than there are items.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for their number, or where the operating system gives no threads.
    pub(crate) fn new(count: usize, items: usize) -> Result<Self, Error> {
        let domain = |expected| Error::OutOfDomain { name: "number of threads", expected, got: count as f64 };
        if !(1..=MOST).contains(&count) {
            return Err(domain("from 1 to 1024"));
        }
        let others = count.min(items).saturating_sub(1);
        let others = (others > 0).then(|| ThreadPoolBuilder::new().num_threads(others).build());
        let others = others.transpose().map_err(|_| domain("as many as the system gives"))?;
        Ok(Self { others })
    }

    /// How many.
    pub(crate) fn count(&self) -> usize {
        1 + self.others.as_ref().map_or(0, ThreadPool::current_num_threads)
    }

    /// Does `work` on every item. Each thread takes the next one when it is free, so that a thread that
    /// begins late, or an item that lasts longer, delays no other.
    ///
    /// # Errors
    /// That of the first item that fails; which of the later ones were worked on is not defined then.
    pub(crate) fn share<T: Send, E: Send>(
        &self,
        mut items: impl Iterator<Item = T> + Send,
        work: impl Fn(T) -> Result<(), E> + Sync,
    ) -> Result<(), E> {
        let Some(others) = &self.others else {
            return items.try_for_each(work);
        };
        let items = Mutex::new(items.enumerate());
        let failed: Mutex<Option<(usize, E)>> = Mutex::new(None);
        let take = || items.lock().unwrap_or_else(PoisonError::into_inner).next();
        let until_none_is_left = || {
            while let Some((index, item)) = take() {
                if let Err(error) = work(item) {
                    let mut first = failed.lock().unwrap_or_else(PoisonError::into_inner);
                    if first.as_ref().is_none_or(|(before, _)| index < *before) {
                        *first = Some((index, error));
                    }
                    return;
                }
            }
        };
        others.in_place_scope(|scope| {
            for _ in 0..others.current_num_threads() {
                scope.spawn(|_| until_none_is_left());
            }
            until_none_is_left();
        });
        let failed = failed.into_inner().unwrap_or_else(PoisonError::into_inner);
        failed.map_or(Ok(()), |(_, error)| Err(error))
    }

    /// Makes an item of every index.
    ///
    /// # Errors
    /// That of the first item that fails.
    pub(crate) fn map<T: Send, E: Send>(
        &self,
        indices: impl Iterator<Item = usize> + Send,
        make: impl Fn(usize) -> Result<T, E> + Sync,
    ) -> Result<Vec<T>, E> {
        let indices: Vec<usize> = indices.collect();
        let mut items: Vec<Option<T>> = indices.iter().map(|_| None).collect();
        self.share(indices.iter().zip(&mut items), |(k, place)| {
            *place = Some(make(*k)?);
            Ok(())
        })?;
        Ok(items.into_iter().flatten().collect())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a failing test may panic")]
    use super::*;

    #[test]
    fn every_item_is_worked_on_once_by_any_number_of_threads() {
        for threads in [1, 2, 3, 16] {
            for count in [0, 1, 2, 100] {
                let mut items = vec![0_u32; count];
                let threads = Threads::new(threads, count).unwrap();
                for _ in 0..3 {
                    let work = |item: &mut u32| {
                        *item += 1;
                        Ok::<(), Error>(())
                    };
                    threads.share(items.iter_mut(), work).unwrap();
                }
                assert!(items.iter().all(|item| *item == 3));
            }
        }
    }

    #[test]
    fn the_first_failure_is_reported() {
        for threads in [1, 2, 3] {
            let threads = Threads::new(threads, 100).unwrap();
            for _ in 0..20 {
                let work = |item: usize| match item {
                    17.. => Err(Error::OutOfDomain { name: "item", expected: "small", got: item as f64 }),
                    _ => Ok(()),
                };
                let error = threads.share(0..100, work).unwrap_err();
                assert!(error.to_string().contains("17"), "{error}");
            }
        }
    }

    #[test]
    fn a_number_of_threads_outside_its_domain_is_refused() {
        for count in [0, 1025] {
            assert!(matches!(Threads::new(count, 4), Err(Error::OutOfDomain { .. })));
        }
    }
}
