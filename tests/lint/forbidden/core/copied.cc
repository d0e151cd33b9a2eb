#include <string>

int Length(const std::string& text);

int Twice(std::string text) { return 2 * Length(text); }
