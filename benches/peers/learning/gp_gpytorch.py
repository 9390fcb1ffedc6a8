"""GPyTorch: an exact process in double precision, its likelihood by Cholesky at every size, SciPy's L-BFGS-B.

With SciPy's optimiser, which knows bounds, it reaches what the others reach; torch's own L-BFGS knows none and may end in NaN.
"""

import gpytorch
import numpy as np
import scipy.optimize
import torch
from gpytorch.constraints import Positive
from peer import BOUNDS, START, Process, serve

torch.set_num_threads(1)
torch.set_default_dtype(torch.float64)
# Queries at once: GPyTorch builds the joint covariance of samples and queries, so that all 10,000 together are slower.
TOGETHER = 500


def logarithmic():
    """Hyper-parameters by their logarithms, as everywhere in this comparison."""
    return Positive(transform=torch.exp, inv_transform=torch.log)


class Exact(gpytorch.models.ExactGP):
    def __init__(self, inputs, output):
        likelihood = gpytorch.likelihoods.GaussianLikelihood(noise_constraint=logarithmic())
        super().__init__(inputs, output, likelihood)
        base = gpytorch.kernels.RBFKernel(ard_num_dims=7, lengthscale_constraint=logarithmic())
        self.kernel = gpytorch.kernels.ScaleKernel(base, outputscale_constraint=logarithmic())
        self.raw = [self.kernel.raw_outputscale, base.raw_lengthscale, likelihood.noise_covar.raw_noise]

    def forward(self, inputs):
        return gpytorch.distributions.MultivariateNormal(torch.zeros(len(inputs)), self.kernel(inputs))

    def place(self, theta):
        with torch.no_grad():
            for raw, values in zip(self.raw, (theta[:1], theta[1:8], theta[8:])):
                raw.copy_(torch.as_tensor(values).reshape(raw.shape))


def fit(inputs, output):
    inputs, output = torch.as_tensor(inputs), torch.as_tensor(output)
    model = Exact(inputs, output)
    model.train()
    likelihood = gpytorch.mlls.ExactMarginalLogLikelihood(model.likelihood, model)

    def loss(theta):
        model.place(theta)
        model.zero_grad()
        value = -likelihood(model(inputs), output) * len(output)
        value.backward()
        return value.item(), torch.cat([raw.grad.reshape(-1) for raw in model.raw]).numpy()

    exact = gpytorch.settings.fast_computations(False, False, False)
    with gpytorch.settings.max_cholesky_size(100_000), exact:
        found = scipy.optimize.minimize(loss, START, jac=True, method="L-BFGS-B", bounds=BOUNDS)
        model.place(found.x)
    model.eval()
    return model, -found.fun, found.nfev


def predict(models, queries):
    means, variances = [], []
    with torch.no_grad(), gpytorch.settings.max_cholesky_size(100_000), gpytorch.settings.fast_pred_var():
        parts = torch.as_tensor(queries).split(TOGETHER)
        for model in models:
            found = [model(part) for part in parts]
            means.append(torch.cat([one.mean for one in found]))
            variances.append(torch.cat([one.variance for one in found]))
    return torch.stack(means, 1).numpy(), torch.stack(variances, 1).numpy()


serve(Process(fit, predict).tasks(), {"GPyTorch": gpytorch.__version__, "PyTorch": torch.__version__})
