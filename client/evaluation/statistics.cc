#include "client/evaluation/statistics.h"

#include <algorithm>
#include <cmath>

namespace isthmus::evaluation {

Statistics Summarize(std::vector<double> values) {
  Statistics out;
  out.count = values.size();
  if (values.empty()) return out;
  const auto count = static_cast<double>(values.size());
  std::sort(values.begin(), values.end());
  for (const double value : values) {
    out.mean += value / count;
    out.rmse += value * value / count;
  }
  out.rmse = std::sqrt(out.rmse);
  for (const double value : values) out.std += (value - out.mean) * (value - out.mean) / count;
  out.std = std::sqrt(out.std);
  const size_t half = values.size() / 2;
  out.median = values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
  out.min = values.front();
  out.max = values.back();
  return out;
}

}  // namespace isthmus::evaluation
