//! Numbers out of buffers: every range is checked against the bytes that are there.

use super::document::{Accessor, Document, View};
use crate::error::{Place, ReadError};
use glam::DVec3;

/// What a reader of accessors needs.
pub struct Source<'a> {
    /// The document.
    pub document: &'a Document,
    /// Its buffers.
    pub buffers: &'a [Vec<u8>],
    /// Most values that are taken from an accessor.
    pub most: u64,
}

/// How a number is written.
#[derive(Clone, Copy)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(code: u32) -> Option<Component> {
        match code {
            5120 => Some(Component::I8),
            5121 => Some(Component::U8),
            5122 => Some(Component::I16),
            5123 => Some(Component::U16),
            5125 => Some(Component::U32),
            5126 => Some(Component::F32),
            _ => None,
        }
    }

    fn size(self) -> usize {
        match self {
            Component::I8 | Component::U8 => 1,
            Component::I16 | Component::U16 => 2,
            Component::U32 | Component::F32 => 4,
        }
    }

    /// The value of so many bytes; from −1 to 1 where it is normalised.
    fn value(self, b: &[u8], is_normalised: bool) -> f64 {
        let (value, most) = match self {
            Component::I8 => (f64::from(b[0] as i8), 127.0),
            Component::U8 => (f64::from(b[0]), 255.0),
            Component::I16 => (f64::from(i16::from_le_bytes([b[0], b[1]])), 32767.0),
            Component::U16 => (f64::from(u16::from_le_bytes([b[0], b[1]])), 65535.0),
            Component::U32 => return f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            Component::F32 => return f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        };
        if is_normalised { (value / most).max(-1.0) } else { value }
    }
}

impl Source<'_> {
    /// Positions: three numbers each.
    pub fn positions(&self, index: usize) -> Result<Vec<DVec3>, ReadError> {
        let accessor = self.accessor(index, "VEC3")?;
        let component = Component::of(accessor.component_type).ok_or_else(|| unknown_type(index))?;
        let read = |b: &[u8]| {
            let number = |k: usize| component.value(&b[k * component.size()..], accessor.normalized);
            DVec3::new(number(0), number(1), number(2))
        };
        self.values(index, accessor, 3 * component.size(), read, DVec3::ZERO)
    }

    /// Indices of corners.
    pub fn indices(&self, index: usize) -> Result<Vec<u32>, ReadError> {
        let accessor = self.accessor(index, "SCALAR")?;
        let component = index_type(accessor.component_type).ok_or_else(|| unknown_type(index))?;
        self.values(index, accessor, component.size(), |b| component.value(b, false) as u32, 0)
    }

    fn accessor(&self, index: usize, shape: &str) -> Result<&Accessor, ReadError> {
        let accessor = self.document.accessors.0.get(index).ok_or_else(|| missing("accessors", index))?;
        if accessor.shape != shape {
            return Err(broken(
                index,
                format!("its type is `{}`, not {shape}", crate::words::shown(&accessor.shape)),
            ));
        }
        if accessor.count > self.most {
            let message = format!("{} values exceed the limit of {}", accessor.count, self.most);
            return Err(broken(index, message).try_this("simplify the mesh, or raise `max_triangles`"));
        }
        Ok(accessor)
    }

    /// The values of an accessor; zeros where it has no bytes, and those of `sparse` in their places.
    fn values<T: Copy>(
        &self,
        index: usize,
        accessor: &Accessor,
        size: usize,
        read: impl Fn(&[u8]) -> T,
        zero: T,
    ) -> Result<Vec<T>, ReadError> {
        let count = accessor.count as usize;
        let mut values = match accessor.buffer_view {
            None => vec![zero; count],
            Some(view) => {
                let (bytes, stride) = self.range(index, view, accessor.byte_offset, accessor.count, size)?;
                (0..count).map(|k| read(&bytes[k * stride..k * stride + size])).collect()
            }
        };
        let Some(sparse) = &accessor.sparse else { return Ok(values) };
        let kind = index_type(sparse.indices.component_type).ok_or_else(|| unknown_type(index))?;
        let (places, place_stride) = self.range(
            index,
            sparse.indices.buffer_view,
            sparse.indices.byte_offset,
            sparse.count,
            kind.size(),
        )?;
        let (bytes, stride) =
            self.range(index, sparse.values.buffer_view, sparse.values.byte_offset, sparse.count, size)?;
        for k in 0..sparse.count as usize {
            let place = kind.value(&places[k * place_stride..], false) as usize;
            let value = values
                .get_mut(place)
                .ok_or_else(|| broken(index, format!("value {place} does not exist")))?;
            *value = read(&bytes[k * stride..k * stride + size]);
        }
        Ok(values)
    }

    /// The bytes of `count` values of `size` bytes from an offset of a view on, and the step from one to the next.
    fn range(
        &self,
        index: usize,
        view: usize,
        offset: u64,
        count: u64,
        size: usize,
    ) -> Result<(&[u8], usize), ReadError> {
        let View { buffer, byte_offset, byte_length, byte_stride } =
            self.document.buffer_views.0.get(view).ok_or_else(|| missing("bufferViews", view))?;
        let bytes = self.buffers.get(*buffer).ok_or_else(|| missing("buffers", *buffer))?;
        let outside = || broken(index, "it reaches beyond its buffer".into());
        let view_end = byte_offset.checked_add(*byte_length).ok_or_else(outside)?;
        let bytes = bytes.get(*byte_offset as usize..view_end as usize).ok_or_else(outside)?;
        let bytes = bytes.get(offset as usize..).ok_or_else(outside)?;
        let stride = byte_stride.unwrap_or(size as u64).max(size as u64);
        let needed = count.saturating_sub(1).checked_mul(stride).and_then(|n| n.checked_add(size as u64));
        let needed = if count == 0 { Some(0) } else { needed };
        match needed {
            Some(needed) if needed <= bytes.len() as u64 => Ok((bytes, stride as usize)),
            _ => Err(outside()),
        }
    }
}

/// The types that indices may have.
fn index_type(code: u32) -> Option<Component> {
    Component::of(code).filter(|c| matches!(c, Component::U8 | Component::U16 | Component::U32))
}

fn unknown_type(index: usize) -> ReadError {
    broken(index, "its component type is not known here".into())
}

fn broken(index: usize, message: String) -> ReadError {
    ReadError::new(Place::File, message).inside(format!("accessors[{index}]"))
}

/// An index that leads nowhere.
pub fn missing(list: &str, index: usize) -> ReadError {
    ReadError::new(Place::File, "it does not exist").inside(format!("{list}[{index}]"))
}
