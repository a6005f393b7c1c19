// Text for HTML and SVG, shared by the report and its plots.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace recede::detail {

/// The text with &, <, >, " and ' as entities, and control characters, which no markup may hold, as spaces.
std::string escape_markup(std::string_view text);

/// Digits in groups of three with narrow no-break spaces between them: 75 408.
std::string grouped(std::size_t number);

/// Three significant digits; exponents are written as powers of ten (4.2×10⁻⁷) below 0.001 and from a million
/// on.
std::string short_number(double number);

/// A share of 1 as `short_number` of percent.
std::string percent(double share);

}  // namespace recede::detail
