//! Room for any number of sensors and hits.

use alloc::vec;
use alloc::vec::Vec;

use super::{Capacity, Item, List, ResponsePairs};

/// Room for any number of sensors and hits, on the heap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unbounded;

impl Capacity for Unbounded {
    type Sensors<T: Item> = Vec<T>;
    type Hits<T: Item> = Vec<T>;
    type Responses<T: Item + Copy> = Vec<T>;
    type ResponsePairs<T: Item + Copy> = ResponsePairVec<T>;

    fn responses<T: Item + Copy>(
        sensors: usize,
        value_of: impl FnMut(usize) -> T,
    ) -> Self::Responses<T> {
        (0..3 * sensors).map(value_of).collect()
    }

    fn response_pairs<T: Item + Copy>(sensors: usize, value: T) -> Self::ResponsePairs<T> {
        let responses = 3 * sensors;
        ResponsePairVec { pairs: vec![value; responses * responses], responses }
    }
}

/// One value per pair of the responses of any number of sensors.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponsePairVec<T> {
    pairs: Vec<T>,
    responses: usize,
}

impl<T> AsRef<[T]> for ResponsePairVec<T> {
    fn as_ref(&self) -> &[T] {
        &self.pairs
    }
}

impl<T> AsMut<[T]> for ResponsePairVec<T> {
    fn as_mut(&mut self) -> &mut [T] {
        &mut self.pairs
    }
}

impl<T: Item + Copy> ResponsePairs<T> for ResponsePairVec<T> {
    fn responses(&self) -> usize {
        self.responses
    }
}

impl<T: Item> List<T> for Vec<T> {
    fn push(&mut self, item: T) -> Result<(), T> {
        self.push(item);
        Ok(())
    }

    fn remove(&mut self, index: usize) -> T {
        self.remove(index)
    }
}
