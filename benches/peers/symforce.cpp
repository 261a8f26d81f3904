// SymForce: the generated functions of one sample, called for all. `symforce JOB FOLDER`.
#include "common.h"
#include "normal_equations.h"
#include "residual_jacobian.h"

int main(int, char** arguments) {
  const std::string job = arguments[1];
  const Data data(arguments[2]);
  const auto at = [&](const Sample& sample, Residual& residual, Jacobian& jacobian) {
    Eigen::Matrix<double, 3, TANGENT> columns;
    sym::ResidualJacobian(data.truth, sample.angle, sample.rate, sample.reading, data.weight,
                          &residual, &columns);
    jacobian = columns;
  };
  if (job == "check") {
    tell_check(data, at);
  } else if (job == "J") {
    tell_time(data, [&] { linearise(data, at); });
  } else if (job == "J+NE") {
    tell_time(data, [&] {
      Hessian sum = Hessian::Zero(), hessian;
      Gradient slope = Gradient::Zero(), gradient;
      for (const Sample& sample : data.samples) {
        sym::NormalEquations(data.truth, sample.angle, sample.rate, sample.reading, data.weight,
                             &hessian, &gradient);
        sum += hessian;
        slope += gradient;
      }
      keep(sum);
      keep(slope);
    });
  }
}
