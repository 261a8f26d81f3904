// What the C++ peers share: the data, the order of the state, timing and the way results are told.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include <Eigen/Core>

// radius, quaternion w x y z, position x y z, three delays, collimation, index, offset.
constexpr int STATE = 14;
// The quaternion's tangent has three: a turn from the right.
constexpr int TANGENT = 13;

using State = Eigen::Matrix<double, STATE, 1>;
using Residual = Eigen::Matrix<double, 3, 1>;
using Jacobian = Eigen::Matrix<double, 3, TANGENT, Eigen::RowMajor>;
using Hessian = Eigen::Matrix<double, TANGENT, TANGENT>;
using Gradient = Eigen::Matrix<double, TANGENT, 1>;

inline std::vector<double> read(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  std::vector<double> values(file.tellg() / sizeof(double));
  file.seekg(0);
  file.read(reinterpret_cast<char*>(values.data()), values.size() * sizeof(double));
  return values;
}

struct Sample {
  double angle, rate;
  Residual reading;
};

struct Data {
  std::vector<Sample> samples;
  Residual weight;
  State truth, start;

  explicit Data(const std::string& folder) {
    const std::vector<double> all = read(folder + "/samples.f64");
    const size_t n = all.size() / 5;
    for (size_t i = 0; i < n; ++i) {
      samples.push_back({all[i], all[n + i], {all[2 * n + i], all[3 * n + i], all[4 * n + i]}});
    }
    weight = Residual(read(folder + "/sigma.f64").data()).cwiseInverse();
    truth = State(read(folder + "/truth.f64").data());
    start = State(read(folder + "/start.f64").data());
  }
};

inline double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Keeps a result from being optimised away.
template <typename T>
void keep(const T& value) {
  asm volatile("" : : "r"(&value) : "memory");
}

// Median seconds of repeated calls, after one that is not counted.
template <typename Work>
double timed(Work work) {
  work();
  std::vector<double> times;
  const double begin = now();
  while (times.size() < 5 || now() - begin < 0.5) {
    const double start = now();
    work();
    times.push_back(now() - start);
  }
  std::sort(times.begin(), times.end());
  return times[times.size() / 2];
}

// Times a job on all samples and prints it as a JSON line.
template <typename Work>
void tell_time(const Data& data, Work work) {
  std::printf("{\"job\": \"time\", \"ns_per_sample\": %.6g}\n",
              timed(work) / data.samples.size() * 1e9);
}

inline std::string list(const double* values, size_t count) {
  std::string text = "[";
  for (size_t i = 0; i < count; ++i) {
    char number[40];
    std::snprintf(number, sizeof number, "%s%.17g", i ? ", " : "", values[i]);
    text += number;
  }
  return text + "]";
}

// Prints residuals and Jacobians for comparison; `at(sample, residual, jacobian)` computes them.
template <typename At>
void tell_check(const Data& data, At at) {
  std::vector<double> residuals, jacobians;
  for (const Sample& sample : data.samples) {
    Residual residual;
    Jacobian jacobian;
    at(sample, residual, jacobian);
    residuals.insert(residuals.end(), residual.data(), residual.data() + residual.size());
    jacobians.insert(jacobians.end(), jacobian.data(), jacobian.data() + jacobian.size());
  }
  std::printf("{\"job\": \"check\", \"residual\": %s, \"jacobian\": %s}\n",
              list(residuals.data(), residuals.size()).c_str(),
              list(jacobians.data(), jacobians.size()).c_str());
}

// Residuals and Jacobians of all samples, one after the other.
template <typename At>
void linearise(const Data& data, At at) {
  Residual residual;
  Jacobian jacobian;
  for (const Sample& sample : data.samples) {
    at(sample, residual, jacobian);
    keep(residual);
    keep(jacobian);
  }
}

// The same with the lower triangle of J^T J and J^T r summed up.
template <typename At>
void normal_equations(const Data& data, At at) {
  Hessian hessian = Hessian::Zero();
  Gradient gradient = Gradient::Zero();
  Residual residual;
  Jacobian jacobian;
  for (const Sample& sample : data.samples) {
    at(sample, residual, jacobian);
    hessian.noalias() += jacobian.transpose() * jacobian;
    gradient.noalias() += jacobian.transpose() * residual;
  }
  keep(hessian);
  keep(gradient);
}
