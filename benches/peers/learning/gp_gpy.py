"""GPy: `GPRegression` with its own L-BFGS-B."""

import logging
import warnings

import GPy
import numpy as np
from peer import BOUNDS, START, Process, serve

warnings.filterwarnings("ignore")
logging.disable(logging.CRITICAL)


def fit(inputs, output):
    start, bounds = np.exp(START), np.exp(BOUNDS)
    kernel = GPy.kern.RBF(7, variance=start[0], lengthscale=start[1:8], ARD=True)
    model = GPy.models.GPRegression(inputs, output[:, None], kernel, noise_var=start[8], normalizer=False)
    model.kern.variance.constrain_bounded(*bounds[0], warning=False)
    model.kern.lengthscale.constrain_bounded(*bounds[1], warning=False)
    model.likelihood.variance.constrain_bounded(*bounds[8], warning=False)
    run = model.optimize("lbfgsb", max_iters=15000)
    return model, float(np.ravel(model.log_likelihood())[0]), int(run.funct_eval or 0)


def predict(models, queries):
    means, variances = zip(*(model.predict_noiseless(queries) for model in models))
    return np.hstack(means), np.hstack(variances)


serve(Process(fit, predict).tasks(), {"GPy": GPy.__version__})
