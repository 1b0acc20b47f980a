// SPDX-License-Identifier: MIT
#pragma once

#include <clocale>
#include <locale>
#include <string>

namespace dynfilter_test {

/// During its lifetime, C++ streams write 1.234,5.
/// printf and strtod do so too if the system has such a locale.
class CommaLocale {
 public:
  CommaLocale()
      : c_before_(std::setlocale(LC_NUMERIC, nullptr)),
        before_(std::locale::global(std::locale(std::locale::classic(), new Comma))) {
    for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8", "de_DE.utf8", "de_DE"})
      in_c_ = in_c_ || std::setlocale(LC_NUMERIC, name) != nullptr;
  }
  ~CommaLocale() {
    std::locale::global(before_);
    std::setlocale(LC_NUMERIC, c_before_.c_str());
  }
  CommaLocale(const CommaLocale&) = delete;
  CommaLocale& operator=(const CommaLocale&) = delete;

  /// True if printf and strtod also use a comma.
  bool in_c() const { return in_c_; }

 private:
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  std::string c_before_;
  std::locale before_;
  bool in_c_ = false;
};

}  // namespace dynfilter_test
