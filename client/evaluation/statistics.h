// Statistics of a list of errors.
#pragma once

#include <cstddef>
#include <vector>

namespace isthmus::evaluation {

// In the unit of the errors. All are 0 where there is nothing.
struct Statistics {
  size_t count = 0;
  double rmse = 0;  // sqrt(1/n sum e^2).
  double mean = 0;
  double median = 0;  // For an even number: the mean of the middle two.
  double std = 0;     // sqrt(1/n sum (e - mean)^2), of these errors, not of a population.
  double min = 0, max = 0;
};

Statistics Summarize(std::vector<double> values);

}  // namespace isthmus::evaluation
