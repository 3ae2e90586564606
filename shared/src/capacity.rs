//! How many sensors and hits there is room for, and what holds them.
//!
//! A rig has memory for a stated number of both ([`Fixed`], [`Rig`]); a computer for any ([`Unbounded`], with the
//! feature `alloc`). Every type with a value per sensor, hit or response is generic over a [`Capacity`], so both run
//! the same solvers.

#[cfg(any(test, feature = "alloc"))]
mod unbounded;

#[cfg(any(test, feature = "alloc"))]
pub use unbounded::{ResponsePairVec, Unbounded};

use core::array::from_fn;
use core::fmt::Debug;
use core::ops::{Deref, DerefMut};

/// Number of triaxial sensors that the rig has inputs for.
pub const RIG_SENSORS: usize = 3;
/// Number of hit DOFs that the rig has memory for.
pub const RIG_HITS: usize = 12;

/// Bound on the elements of a [`List`].
pub trait Item: Clone + Debug + PartialEq {}

impl<T: Clone + Debug + PartialEq> Item for T {}

/// A list that grows up to its capacity.
pub trait List<T>:
    Clone + Debug + PartialEq + Default + Deref<Target = [T]> + DerefMut + FromIterator<T>
{
    /// Appends an item.
    ///
    /// # Errors
    /// Returns the item when the list is full.
    fn push(&mut self, item: T) -> Result<(), T>;

    /// Removes the item at this index; those after it move up.
    ///
    /// # Panics
    /// When the list has no item at this index.
    fn remove(&mut self, index: usize) -> T;

    /// The first of these items, as many as the list has room for.
    fn truncated(items: impl IntoIterator<Item = T>) -> Self {
        let mut list = Self::default();
        for item in items {
            if list.push(item).is_err() {
                break;
            }
        }
        list
    }
}

/// How many sensors and hits there is room for, and what holds them.
///
/// ```
/// # use massline_shared::capacity::Fixed;
/// # use massline_shared::layout::Layout;
/// // Any number of hits up to ten, without an allocator.
/// let layout = Layout::<f64, Fixed<3, 10>>::default();
/// assert!(layout.hits.is_empty());
/// ```
pub trait Capacity: Copy + Debug + PartialEq + 'static {
    /// A list with an item for each sensor.
    type Sensors<T: Item>: List<T>;
    /// A list with an item for each hit.
    type Hits<T: Item>: List<T>;
    /// One value per response: three for each sensor.
    type Responses<T: Item + Copy>: Item + AsRef<[T]> + AsMut<[T]>;
    /// One value per pair of responses, column by column.
    type ResponsePairs<T: Item + Copy>: ResponsePairs<T>;

    /// The values that `value_of` gives for each response of this many sensors.
    fn responses<T: Item + Copy>(
        sensors: usize,
        value_of: impl FnMut(usize) -> T,
    ) -> Self::Responses<T>;
    /// The same value for each pair of responses of this many sensors.
    fn response_pairs<T: Item + Copy>(sensors: usize, value: T) -> Self::ResponsePairs<T>;
}

/// One value per pair of responses, column by column.
pub trait ResponsePairs<T>: Item + AsRef<[T]> + AsMut<[T]> {
    /// Number of responses that there is room for.
    fn responses(&self) -> usize;
}

/// Room for `SENSORS` sensors and `HITS` hits, without an allocator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fixed<const SENSORS: usize, const HITS: usize>;

/// What a rig has inputs and memory for.
pub type Rig = Fixed<RIG_SENSORS, RIG_HITS>;

/// One value per response of `S` sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResponseArray<T, const S: usize>([[T; 3]; S]);

/// One value per pair of the responses of `S` sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResponsePairArray<T, const S: usize>([[[[T; 3]; S]; 3]; S]);

impl<T, const S: usize> AsRef<[T]> for ResponseArray<T, S> {
    fn as_ref(&self) -> &[T] {
        self.0.as_flattened()
    }
}

impl<T, const S: usize> AsMut<[T]> for ResponseArray<T, S> {
    fn as_mut(&mut self) -> &mut [T] {
        self.0.as_flattened_mut()
    }
}

impl<T, const S: usize> AsRef<[T]> for ResponsePairArray<T, S> {
    fn as_ref(&self) -> &[T] {
        self.0.as_flattened().as_flattened().as_flattened()
    }
}

impl<T, const S: usize> AsMut<[T]> for ResponsePairArray<T, S> {
    fn as_mut(&mut self) -> &mut [T] {
        self.0.as_flattened_mut().as_flattened_mut().as_flattened_mut()
    }
}

impl<const SENSORS: usize, const HITS: usize> Capacity for Fixed<SENSORS, HITS> {
    type Sensors<T: Item> = heapless::Vec<T, SENSORS>;
    type Hits<T: Item> = heapless::Vec<T, HITS>;
    type Responses<T: Item + Copy> = ResponseArray<T, SENSORS>;
    type ResponsePairs<T: Item + Copy> = ResponsePairArray<T, SENSORS>;

    fn responses<T: Item + Copy>(
        _sensors: usize,
        mut value_of: impl FnMut(usize) -> T,
    ) -> Self::Responses<T> {
        ResponseArray(from_fn(|sensor| from_fn(|axis| value_of(3 * sensor + axis))))
    }

    fn response_pairs<T: Item + Copy>(_sensors: usize, value: T) -> Self::ResponsePairs<T> {
        ResponsePairArray([[[[value; 3]; SENSORS]; 3]; SENSORS])
    }
}

impl<T: Item + Copy, const S: usize> ResponsePairs<T> for ResponsePairArray<T, S> {
    fn responses(&self) -> usize {
        3 * S
    }
}

impl<T: Item, const N: usize> List<T> for heapless::Vec<T, N> {
    fn push(&mut self, item: T) -> Result<(), T> {
        self.push(item)
    }

    fn remove(&mut self, index: usize) -> T {
        self.remove(index)
    }
}
