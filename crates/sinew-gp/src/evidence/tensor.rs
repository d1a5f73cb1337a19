//! The evidence as a differentiable operation of Burn.

use crate::error::{GpError, Result};
use crate::model::Model;
use burn::tensor::{DType, Tensor, TensorData};

/// ln evidence of `model` as a tensor of one number, differentiable in `parameters`: all of the
/// model's, on their scales, in double precision. Whatever computed them, as a network that maps
/// measurements to a diffusivity, can be trained through it.
///
/// Value and gradient come from one factorisation outside of Burn. Since Burn differentiates once
/// only, the tangent at the parameters is all that its graph needs, on any backend.
///
/// ```
/// use burn::tensor::{DType, Device, Tensor, TensorData};
/// use sinew_gp::{
///     Data, Derivative, Domain, Evidence, Model, Noise, Prior, Problem, SquaredExponential,
///     log_evidence_tensor,
/// };
///
/// let domain = Domain::interval("x", [0.0, 1.0])?;
/// let problem = Problem::new(domain, Derivative::along(0))?;
/// let data = Data::new().values(&[[0.1], [0.7]], &[1.0, -0.4], Noise::Known(0.1));
/// let prior = Prior::unconstrained(&problem, &SquaredExponential::new())?;
/// let model = Model::new(prior, data, Evidence::Joint)?;
///
/// let device = Device::flex().autodiff();
/// let parameters = TensorData::new(vec![0.2_f64, -0.5], [2]);
/// let parameters = Tensor::<1>::from_data(parameters, (&device, DType::F64)).require_grad();
/// let evidence = log_evidence_tensor(&model, parameters.clone())?;
/// let slopes = parameters.grad(&evidence.backward()).unwrap();
/// assert_eq!(slopes.into_data().try_to_vec::<f64>().unwrap(), model.evaluate(&[0.2, -0.5])?.gradient);
/// # Ok::<(), sinew_gp::GpError>(())
/// ```
///
/// # Errors
/// As [`Model::evaluate`]; and if the tensor is not of double precision.
pub fn log_evidence_tensor<const D: usize>(
    model: &Model<D>,
    parameters: Tensor<1>,
) -> Result<Tensor<1>> {
    if parameters.dtype() != DType::F64 {
        return Err(precision());
    }
    let detached = parameters.clone().detach();
    let values = detached.to_data().try_to_vec::<f64>().map_err(|_| precision())?;
    let evaluation = model.evaluate(&values)?;
    let device = parameters.device();
    let tensor = |values: Vec<f64>| {
        let count = values.len();
        Tensor::<1>::from_data(TensorData::new(values, [count]), (&device, DType::F64))
    };
    // The difference is zero, its derivative one.
    let tangent = (parameters - detached) * tensor(evaluation.gradient);
    Ok(tangent.sum() + tensor(vec![evaluation.value]))
}

fn precision() -> GpError {
    GpError::Invalid("parameters must be a tensor of double precision; cast it to F64".into())
}
