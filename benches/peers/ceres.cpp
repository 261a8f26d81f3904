// Ceres Solver: AutoDiffCostFunction with a quaternion manifold, and a plain loop over its Jets.
// `ceres-peer JOB FOLDER`; jobs that end in `-jets` are the plain loop's.
#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include "common.h"

// Three derivatives more than needed: whole vector registers, twice as fast as 13.
using Jet = ceres::Jet<double, 16>;

// The first two columns of the matrix of a unit quaternion, all that a target in the plane needs.
template <typename T>
struct Turned {
  T x[3], y[3];

  explicit Turned(const T* q)
      : x{1.0 - 2.0 * (q[2] * q[2] + q[3] * q[3]), 2.0 * (q[1] * q[2] + q[0] * q[3]),
          2.0 * (q[1] * q[3] - q[0] * q[2])},
        y{2.0 * (q[1] * q[2] - q[0] * q[3]), 1.0 - 2.0 * (q[1] * q[1] + q[3] * q[3]),
          2.0 * (q[2] * q[3] + q[0] * q[1])} {}
};

// One sample's residuals; `rest`: radius, position, delays, collimation, index, offset.
struct Model {
  const Sample& sample;
  const Residual& weight;

  // The target in the instrument's frame at a moment: R radius (cos, sin, 0) + position.
  template <typename T>
  void point(const Turned<T>& turned, const T* rest, const T& delay, T* p) const {
    const T angle = sample.angle + sample.rate * delay;
    const T x = rest[0] * cos(angle), y = rest[0] * sin(angle);
    for (int i = 0; i < 3; ++i) p[i] = turned.x[i] * x + turned.y[i] * y + rest[1 + i];
  }

  template <typename T>
  T horizontal(const Turned<T>& turned, const T* rest) const {
    T p[3];
    point(turned, rest, rest[4], p);
    const T flat = p[0] * p[0] + p[1] * p[1];
    return atan2(p[1], p[0]) + rest[7] * sqrt(1.0 + p[2] * p[2] / flat);
  }

  template <typename T>
  T vertical(const Turned<T>& turned, const T* rest) const {
    T p[3];
    point(turned, rest, rest[5], p);
    return atan2(sqrt(p[0] * p[0] + p[1] * p[1]), p[2]) + rest[8];
  }

  template <typename T>
  T distance(const Turned<T>& turned, const T* rest) const {
    T p[3];
    point(turned, rest, rest[6], p);
    return sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) + rest[9];
  }

  static double real(double value) { return value; }
  template <int N>
  static double real(const ceres::Jet<double, N>& value) {
    return value.a;
  }

  template <typename T>
  void residuals(const Turned<T>& turned, const T* rest, T* residual) const {
    residual[0] = sample.reading[0] - horizontal(turned, rest);
    residual[0] -= 2 * M_PI * std::round(real(residual[0]) / (2 * M_PI));
    residual[1] = sample.reading[1] - vertical(turned, rest);
    residual[2] = sample.reading[2] - distance(turned, rest);
    for (int i = 0; i < 3; ++i) residual[i] *= weight[i];
  }

  template <typename T>
  bool operator()(const T* q, const T* rest, T* residual) const {
    residuals(Turned<T>(q), rest, residual);
    return true;
  }
};

void split(const State& state, double* q, double* rest) {
  std::copy_n(state.data() + 1, 4, q);
  rest[0] = state[0];
  std::copy_n(state.data() + 5, 9, rest + 1);
}

// The problem as Ceres sees it: one residual block of three a sample, two parameter blocks.
struct Joint {
  double q[4], rest[10];
  ceres::Problem problem;

  Joint(const Data& data, const State& state) {
    split(state, q, rest);
    problem.AddParameterBlock(q, 4, new ceres::QuaternionManifold);
    problem.AddParameterBlock(rest, 10);
    for (const Sample& sample : data.samples) {
      auto* cost = new ceres::AutoDiffCostFunction<Model, 3, 4, 10>(new Model{sample, data.weight});
      problem.AddResidualBlock(cost, nullptr, q, rest);
    }
  }
};

// Linearises the whole problem; columns: Ceres's tangent of the quaternion, then `rest`.
struct Linearised {
  std::vector<double> residuals;
  ceres::CRSMatrix jacobian;

  void evaluate(Joint& joint) {
    ceres::Problem::EvaluateOptions options;
    options.num_threads = 1;
    options.parameter_blocks = {joint.q, joint.rest};
    joint.problem.Evaluate(options, nullptr, &residuals, nullptr, &jacobian);
  }

  using Rows = Eigen::Matrix<double, Eigen::Dynamic, TANGENT, Eigen::RowMajor>;
  Eigen::Map<const Rows> rows() const {
    return {jacobian.values.data(), jacobian.num_rows, TANGENT};
  }
};

// Ceres turns from the left by half angles: columns of a turn from the right are R/2 times these.
void check(const Data& data) {
  Joint joint(data, data.truth);
  Linearised linearised;
  linearised.evaluate(joint);
  double values[9];
  ceres::QuaternionToRotation(joint.q, values);
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> rotation(values);
  size_t row = 0;
  tell_check(data, [&](const Sample&, Residual& residual, Jacobian& jacobian) {
    residual = Residual(linearised.residuals.data() + row);
    const auto rows = linearised.rows().middleRows<3>(row);
    jacobian.col(0) = rows.col(3);
    jacobian.middleCols<3>(1) = rows.leftCols<3>() * rotation / 2;
    jacobian.rightCols<9>() = rows.rightCols<9>();
    row += 3;
  });
}

// Seeds a state's tangent.
void seed(const State& state, Jet* q, Jet* rest) {
  double real_q[4], real_rest[10];
  split(state, real_q, real_rest);
  Jet turn[4] = {Jet(1.0), Jet(0.0, 1), Jet(0.0, 2), Jet(0.0, 3)};
  for (int i = 1; i < 4; ++i) turn[i].v /= 2;
  Jet fixed[4];
  for (int i = 0; i < 4; ++i) fixed[i] = Jet(real_q[i]);
  ceres::QuaternionProduct(fixed, turn, q);
  rest[0] = Jet(real_rest[0], 0);
  for (int i = 1; i < 10; ++i) rest[i] = Jet(real_rest[i], i + 3);
}

void batch(const Data& data, ceres::LinearSolverType solver) {
  const double begin = now();
  Joint joint(data, data.start);
  ceres::Solver::Options options;
  options.linear_solver_type = solver;
  options.num_threads = 1;
  options.function_tolerance = 1e-10;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &joint.problem, &summary);
  const double seconds = now() - begin;
  State state;
  state << joint.rest[0], Eigen::Map<Eigen::Vector4d>(joint.q),
      Eigen::Map<Eigen::Matrix<double, 9, 1>>(joint.rest + 1);
  std::printf("{\"job\": \"batch\", \"seconds\": %.6g, \"iterations\": %d, \"state\": %s}\n", seconds,
              summary.num_successful_steps, list(state.data(), STATE).c_str());
}

// The delay of each reading by plain Newton steps over a Jet of one variable.
void newton(const Data& data) {
  using One = ceres::Jet<double, 1>;
  One q[4], rest[10];
  double real_q[4], real_rest[10];
  split(data.truth, real_q, real_rest);
  for (int i = 0; i < 4; ++i) q[i] = One(real_q[i]);
  for (int i = 0; i < 10; ++i) rest[i] = One(real_rest[i]);
  const Turned<One> turned(q);
  std::vector<double> delays[3];
  const double seconds = timed([&] {
    for (int measurand = 0; measurand < 3; ++measurand) {
      delays[measurand].clear();
      for (const Sample& sample : data.samples) {
        const Model model{sample, data.weight};
        One moved[10];
        std::copy(rest, rest + 10, moved);
        double delay = 0, step = 1;
        for (int i = 0; i < 8 && std::abs(step) > 1e-12; ++i) {
          moved[4 + measurand] = One(delay, 0);
          One difference = measurand == 0   ? model.horizontal(turned, moved)
                           : measurand == 1 ? model.vertical(turned, moved)
                                            : model.distance(turned, moved);
          difference -= sample.reading[measurand];
          difference -= 2 * M_PI * std::round(difference.a / (2 * M_PI));
          step = difference.a / difference.v[0];
          delay -= step;
        }
        delays[measurand].push_back(delay);
      }
    }
  });
  double medians[3];
  for (int i = 0; i < 3; ++i) {
    std::nth_element(delays[i].begin(), delays[i].begin() + delays[i].size() / 2, delays[i].end());
    medians[i] = delays[i][delays[i].size() / 2];
  }
  std::printf("{\"job\": \"newton\", \"ns_per_sample\": %.6g, \"delays\": %s}\n",
              seconds / data.samples.size() * 1e9, list(medians, 3).c_str());
}

int main(int, char** arguments) {
  const std::string job = arguments[1];
  const Data data(arguments[2]);
  Jet q[4], rest[10];
  seed(data.truth, q, rest);
  // What depends on parameters alone is made once, not once a sample.
  const Turned<Jet> turned(q);
  const auto jets = [&](const Sample& sample, Residual& residual, Jacobian& jacobian) {
    Jet out[3];
    Model{sample, data.weight}.residuals(turned, rest, out);
    for (int i = 0; i < 3; ++i) {
      residual[i] = out[i].a;
      jacobian.row(i) = out[i].v.head<TANGENT>();
    }
  };
  Linearised linearised;
  if (job == "check") {
    check(data);
  } else if (job == "check-jets") {
    tell_check(data, jets);
  } else if (job == "J") {
    Joint joint(data, data.truth);
    tell_time(data, [&] { linearised.evaluate(joint); });
  } else if (job == "J-jets") {
    tell_time(data, [&] { linearise(data, jets); });
  } else if (job == "J+NE") {
    Joint joint(data, data.truth);
    tell_time(data, [&] {
      linearised.evaluate(joint);
      const auto rows = linearised.rows();
      Hessian hessian = Hessian::Zero();
      hessian.selfadjointView<Eigen::Lower>().rankUpdate(rows.transpose());
      const Eigen::Map<const Eigen::VectorXd> residuals(linearised.residuals.data(), rows.rows());
      const Gradient gradient = rows.transpose() * residuals;
      keep(hessian);
      keep(gradient);
    });
  } else if (job == "J+NE-jets") {
    tell_time(data, [&] { normal_equations(data, jets); });
  } else if (job == "newton-jets") {
    newton(data);
  } else if (job == "batch") {
    batch(data, ceres::DENSE_NORMAL_CHOLESKY);
  } else if (job == "batch-qr") {
    batch(data, ceres::DENSE_QR);
  }
}
