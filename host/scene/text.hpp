/// Words and numbers of text formats (OBJ, MTL, ASCII PLY and STL), with the line each stands on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace raig::text {

/// The bytes of a file as characters, without a UTF-8 byte order mark.
/// Throws inputError naming `place` for UTF-16 and for anything else with a NUL in it, with the line.
std::string_view checkText(std::span<const std::byte> bytes, const std::string& place);

/// A whole word as a float, rounded once: decimal ("-1", "+.5", "2.e1"), nan and inf in C's and Microsoft's spelling.
/// Beyond the range of float: infinity or zero. Nothing if any character is left over.
std::optional<float> parseFloat(std::string_view word);

/// A whole word as a decimal integer; nothing if it is none or does not fit.
std::optional<int64_t> parseInteger(std::string_view word);

/// `word` between quotes for an error message: at most 40 characters, unprintable ones as '?'.
std::string quoted(std::string_view word);

/// Without blanks (space, tab, carriage return, form feed, vertical tab, newline) at both ends.
std::string_view trimmed(std::string_view text);

/// A statement with its lines joined: each backslash that ends one, and the line's end, are a blank.
std::string joinedLines(std::string_view statement);

/// Equal but for the case of ASCII letters.
bool equalsIgnoringCase(std::string_view a, std::string_view b);

/// The words of a text, one after the other. Lines end with LF, CR LF or CR. A backslash that ends a line is a blank.
class Words {
public:
    explicit Words(std::string_view text, size_t firstLine = 1) : left_(text), line_(firstLine) {}

    /// The next word; empty at the end.
    std::string_view next();
    /// What is left, trimmed.
    std::string_view rest() const { return trimmed(left_); }
    /// Leaves out what is left of the line.
    void skipLine();
    /// Of the last word, from 1.
    size_t line() const { return line_; }
    /// How many characters are left.
    size_t charactersLeft() const { return left_.size(); }

private:
    void skipBlanks();
    std::string_view left_;
    size_t line_;
};

/// The statements of an OBJ or MTL file: one a line, or several lines joined by backslashes. Comments (#) count as
/// statements.
class Statements {
public:
    explicit Statements(std::string_view text) : left_(text) {}

    /// The next statement, which may be blank; nothing at the end.
    std::optional<std::string_view> next();
    /// The line on which the last statement began, from 1.
    size_t line() const { return line_; }

private:
    std::string_view left_;
    size_t line_ = 0;
    size_t nextLine_ = 1;
};

}  // namespace raig::text
