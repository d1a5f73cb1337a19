//! The one bridge between Burn and plain Rust: differentiable operations on host memory.
//!
//! An operation is a function of slices that returns its output and a [`Pullback`]; [`apply`] makes it a node of Burn's
//! autodiff graph on every backend. On Flex the slices are the tensors' own memory.

use crate::fused::pool::keep_freed_memory;
use crate::fused::rows::add_into;
#[cfg(any(feature = "wgpu", feature = "cuda"))]
use burn::backend::DispatchDevice;
use burn::backend::autodiff::NodeId;
use burn::backend::autodiff::checkpoint::base::Checkpointer;
use burn::backend::autodiff::checkpoint::strategy::CheckpointStrategy;
use burn::backend::autodiff::grads::Gradients;
use burn::backend::autodiff::ops::{Backward, Ops, OpsKind};
use burn::backend::flex::FlexTensor;
use burn::backend::tensor::FloatTensor;
use burn::backend::{
    Autodiff, Backend, Dispatch, DispatchTensor, Flex, TensorMetadata, backend_extension, read_sync,
};
use burn::tensor::{DType, Shape, Tensor, TensorData};
use std::any::Any;
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fmt::{self, Debug, Formatter};
use std::sync::Arc;

/// Whether a tensor of single precision is in the memory of the processor, where fused operations work. A graphics processor
/// would wait for its tensors to go there and back.
pub(crate) fn is_on_host<const D: usize>(tensor: &Tensor<D>) -> bool {
    let is_in_memory = match tensor.device().without_autodiff().as_dispatch() {
        #[cfg(any(feature = "wgpu", feature = "cuda"))]
        DispatchDevice::Cube(_) => false,
        _ => true,
    };
    is_in_memory && tensor.dtype() == DType::F32
}

/// A contiguous single-precision tensor in host memory; clones share it.
#[derive(Clone, Debug)]
pub(crate) struct HostTensor(FlexTensor);

impl HostTensor {
    pub(crate) fn new(values: Vec<f32>, shape: impl Into<Shape>) -> Self {
        Self(FlexTensor::from_data(TensorData::new(values, shape)))
    }

    pub(crate) fn values(&self) -> &[f32] {
        self.0.as_slice().expect("built contiguous and of single precision")
    }

    pub(crate) fn shape(&self) -> Shape {
        self.0.shape()
    }

    /// Shares the memory of Flex tensors, reads back others.
    fn read<B: Backend>(tensor: FloatTensor<B>) -> Self {
        let flex =
            (&tensor as &dyn Any).downcast_ref::<FlexTensor>().map(FlexTensor::to_contiguous);
        let read_back = || {
            let data = read_sync(B::float_into_data(tensor)).expect("tensors can be read back");
            FlexTensor::from_data(data)
        };
        Self(flex.unwrap_or_else(read_back))
    }

    fn write<B: Backend>(self, device: &B::Device) -> FloatTensor<B> {
        let flex = (&self.0 as &dyn Any).downcast_ref::<FloatTensor<B>>().cloned();
        flex.unwrap_or_else(|| B::float_from_data(self.0.into_data(), device))
    }
}

/// Cotangents of the inputs of an operation; none where it was not asked for.
pub(crate) type Cotangents = Vec<Option<Vec<f32>>>;

/// Transposed derivative of an operation at its inputs, from the cotangent of the output. The flags say which inputs need a
/// cotangent; those of others may be left out.
#[derive(Clone)]
pub(crate) struct Pullback(Arc<Pull>);

type Pull = dyn Fn(&[f32], &[bool]) -> Cotangents + Send + Sync;

impl Pullback {
    pub(crate) fn new(
        pull: impl Fn(&[f32], &[bool]) -> Cotangents + Send + Sync + 'static,
    ) -> Self {
        Self(Arc::new(pull))
    }
}

impl Debug for Pullback {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> fmt::Result {
        formatter.write_str("Pullback")
    }
}

/// A differentiable function of host tensors with one output. The flag says whether its derivative is asked for, so that what only
/// that needs is kept. Nodes of Burn's graph are compiled once for each number of inputs, and not for each operation again.
type Operation = dyn Fn(&[HostTensor], bool) -> (HostTensor, Pullback);

/// Evaluates `operation` on single-precision `inputs` and records it for differentiation.
///
/// # Panics
/// For numbers of inputs that no operation has, see the table below.
pub(crate) fn apply<const D: usize>(
    inputs: Vec<DispatchTensor>,
    operation: impl Fn(&[HostTensor], bool) -> (HostTensor, Pullback) + 'static,
) -> Tensor<D> {
    Tensor::from_dispatch(dispatch(&operation, inputs))
}

fn forward<B: Backend, const N: usize>(
    inputs: [FloatTensor<B>; N],
    operation: &Operation,
    tracked: bool,
) -> (FloatTensor<B>, Pullback) {
    keep_freed_memory();
    let device = inputs[0].device();
    let (output, pullback) = operation(&inputs.map(HostTensor::read::<B>), tracked);
    (output.write::<B>(&device), pullback)
}

/// Most entries of [`BEGUN`]; entries of gradients that Burn's own operations consume stay behind.
const MOST_BEGUN: usize = 1 << 12;

thread_local! {
    /// Inner nodes of the autodiff graph whose gradient a host operation has registered. Further host operations add to it
    /// here, for Burn's addition is slow where Burn is not optimised; gradients that are not listed are added by Burn.
    static BEGUN: RefCell<BTreeSet<NodeId>> = const { RefCell::new(BTreeSet::new()) };
}

/// Notes that a gradient is registered; whether a host operation has registered one before.
fn is_begun(node: NodeId) -> bool {
    BEGUN.with_borrow_mut(|begun| {
        if begun.len() >= MOST_BEGUN {
            begun.clear();
        }
        !begun.insert(node)
    })
}

#[derive(Debug)]
struct HostBackward;

impl<B: Backend, const N: usize> Backward<B, N> for HostBackward {
    /// Derivative of the operation, and the shapes of the gradients.
    type State = (Pullback, [Shape; N]);

    fn backward(self, ops: Ops<Self::State, N>, gradients: &mut Gradients, _: &mut Checkpointer) {
        let cotangent = gradients.consume::<B>(&ops.node);
        BEGUN.with_borrow_mut(|begun| begun.remove(&ops.node.id));
        let device = cotangent.device();
        let cotangent = HostTensor::read::<B>(cotangent);
        let (Pullback(pull), shapes) = ops.state;
        let needed = ops.parents.each_ref().map(Option::is_some);
        let results = pull(cotangent.values(), &needed);
        for ((parent, result), shape) in ops.parents.iter().zip(results).zip(shapes) {
            if let (Some(parent), Some(mut values)) = (parent, result) {
                let is_leaf = parent.parents.is_empty();
                if !is_leaf && is_begun(parent.id) {
                    let begun = HostTensor::read::<B>(gradients.consume::<B>(parent));
                    add_into(&mut values, begun.values());
                }
                let gradient = HostTensor::new(values, shape).write::<B>(&device);
                gradients.register::<B>(parent.id, gradient);
            }
        }
    }
}

fn differentiable<B: Backend, C: CheckpointStrategy, const N: usize>(
    inputs: [FloatTensor<Autodiff<B, C>>; N],
    operation: &Operation,
) -> FloatTensor<Autodiff<B, C>> {
    let nodes = inputs.each_ref().map(|input| input.node());
    let shapes = inputs.each_ref().map(|input| input.shape());
    let primitives = inputs.map(|input| input.into_primitive());
    match Backward::<B, N>::prepare::<C>(HostBackward, nodes).compute_bound().stateful() {
        OpsKind::Tracked(step) => {
            let (output, pullback) = forward::<B, N>(primitives, operation, true);
            step.finish((pullback, shapes), output)
        }
        OpsKind::UnTracked(step) => step.finish(forward::<B, N>(primitives, operation, false).0),
    }
}

/// Burn routes operations of a fixed number of tensors; one method for each number in use.
macro_rules! operations {
    ($($name:ident($count:literal: $($input:ident),+);)+) => {
        /// Host operations by their number of inputs.
        #[backend_extension(Autodiff, Flex, NdArray: cfg(feature = "ndarray"), Cube: cfg(any(feature = "wgpu", feature = "cuda")))]
        pub(crate) trait HostBackend: Backend {
            $(#[allow(clippy::too_many_arguments)]
            fn $name($($input: FloatTensor<Self>),+, operation: &Operation) -> FloatTensor<Self> {
                forward::<Self, $count>([$($input),+], operation, false).0
            })+
        }

        impl HostBackend for Flex {}

        #[cfg(feature = "ndarray")]
        impl HostBackend for burn::backend::NdArray {}

        #[cfg(any(feature = "wgpu", feature = "cuda"))]
        impl HostBackend for burn::backend::Cube {}

        impl<B: Backend, C: CheckpointStrategy> HostBackend for Autodiff<B, C> {
            $(fn $name($($input: FloatTensor<Self>),+, operation: &Operation) -> FloatTensor<Self> {
                differentiable::<B, C, $count>([$($input),+], operation)
            })+
        }

        fn dispatch(operation: &Operation, inputs: Vec<DispatchTensor>) -> DispatchTensor {
            match inputs.len() {
                $($count => {
                    let [$($input),+]: [DispatchTensor; $count] =
                        inputs.try_into().expect("the length that was matched");
                    Dispatch::$name($($input),+, operation)
                })+
                other => panic!("no host operation takes {other} tensors"),
            }
        }
    };
}

operations! {
    of_one(1: a);
    of_two(2: a, b);
    of_three(3: a, b, c);
    of_seven(7: a, b, c, d, e, f, g);
    of_eight(8: a, b, c, d, e, f, g, h);
    of_nine(9: a, b, c, d, e, f, g, h, i);
    of_ten(10: a, b, c, d, e, f, g, h, i, j);
    of_eleven(11: a, b, c, d, e, f, g, h, i, j, k);
}
