"""C strings for numba code: the words and numbers of an MJCF config, and sentences about them."""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false

import math

import numpy as np

from ....kernels import inner
from ._memory import character_at, localeconv, pointer_at, strtod, warn

BLANKS = (ord(" "), ord("\t"), ord("\n"), ord("\r"))
SENTENCE_LIMIT = 600
LARGEST, SMALLEST = 1e100, 1e-100  # sizes of numbers, whose squares and products stay finite


@inner
def length(text):
    """Returns the length of the C string at `text`."""
    count = 0
    while character_at(text + count) != 0:
        count += 1
    return count


@inner
def ends_with(text, ending):
    """Returns whether the C string at `text` ends with the bytes `ending`."""
    start = length(text) - len(ending)
    return start >= 0 and is_word(text + start, ending, 0, len(ending))


@inner
def starts_with(text, beginning):
    """Returns whether the C string at `text` starts with the bytes `beginning`."""
    for i in range(len(beginning)):
        if character_at(text + i) != beginning[i]:  # a shorter text ends in 0 and differs there
            return False
    return True


@inner
def equals(text, word):
    """Returns whether the C string at `text` is the bytes `word`."""
    return is_word(text, word, 0, len(word))


@inner
def behind_blanks(text):
    """Returns the address of the first character at or after `text` that is not a blank."""
    while character_at(text) in BLANKS:
        text += 1
    return text


@inner
def behind_digits(text):
    """Returns the address of the first character at or after `text` that is not a digit."""
    while ord("0") <= character_at(text) <= ord("9"):
        text += 1
    return text


@inner
def behind_number(text):
    """Returns the address behind the decimal number at `text`; `text` itself if there is none."""
    start = text + (character_at(text) in (ord("-"), ord("+")))
    end = behind_digits(start)
    digits = end - start
    if character_at(end) == ord("."):
        fraction = behind_digits(end + 1)
        digits += fraction - end - 1
        end = fraction
    if digits == 0:
        return text
    if character_at(end) in (ord("e"), ord("E")):
        power = end + 1 + (character_at(end + 1) in (ord("-"), ord("+")))
        behind = behind_digits(power)
        end = behind if behind > power else text
    return end


@inner
def to_number(text, end):
    """Returns the decimal number between two addresses, rounded as Python rounds it.

    C's strtod does that, but it expects the decimal point of the process's locale.
    """
    point = pointer_at(localeconv())
    copy = np.zeros(end - text + length(point) + 1, np.uint8)
    n = 0
    for i in range(text, end):
        if character_at(i) == ord("."):
            for j in range(length(point)):
                copy[n] = character_at(point + j)
                n += 1
        else:
            copy[n] = character_at(i)
            n += 1
    value = strtod(copy.ctypes.data, 0)
    return value if copy[n] == 0 else math.nan  # reading the copy last keeps it alive till then


@inner
def parse_numbers(text, values):
    """Fills `values` with the blank-separated numbers of the C string at `text`.

    Returns how many numbers there are, even if they do not all fit; -1 if one is not finite,
    larger than 1e100, or smaller than 1e-100 and not 0.
    """
    count = 0
    text = behind_blanks(text)
    while character_at(text) != 0:
        end = behind_number(text)
        if end == text or not (character_at(end) == 0 or character_at(end) in BLANKS):
            return -1
        value = to_number(text, end)
        size = abs(value)
        if not size <= LARGEST or 0 < size < SMALLEST:
            return -1
        if count < values.size:
            values[count] = value
        count += 1
        text = behind_blanks(end)
    return count


@inner
def count_words(text):
    """Returns how many blank-separated words the C string at `text` has."""
    count = 0
    text = behind_blanks(text)
    while character_at(text) != 0:
        while character_at(text) != 0 and character_at(text) not in BLANKS:
            text += 1
        count += 1
        text = behind_blanks(text)
    return count


@inner
def add_text(sentence, n, text):
    """Appends the C string at `text` to a sentence of n characters; returns the new n."""
    i = 0
    while character_at(text + i) != 0 and n < SENTENCE_LIMIT - 1:
        sentence[n] = character_at(text + i)
        n, i = n + 1, i + 1
    return n


@inner
def add(sentence, n, words):
    """Appends the bytes `words` to a sentence of n characters; returns the new n."""
    for i in range(len(words)):
        if n < SENTENCE_LIMIT - 1:
            sentence[n] = words[i]
            n += 1
    return n


@inner
def issue(sentence):
    """Issues a sentence as a MuJoCo warning."""
    warn(sentence.ctypes.data)
    return sentence[0]  # the reference keeps it alive till here


@inner
def choice_of(text, words):
    """Returns the number, from 0, of the word that the C string at `text` is; -1 for none.

    Args:
        text: Address of the C string.
        words: Bytes with a blank between every two words, as b"rad deg".
    """
    number, start = 0, 0
    for end in range(len(words) + 1):
        if end == len(words) or words[end] == ord(" "):
            if is_word(text, words, start, end):
                return number
            number, start = number + 1, end + 1
    return -1


@inner
def is_word(text, words, start, end):
    """Returns whether the C string at `text` is the bytes from `start` to `end`."""
    for i in range(start, end):
        if character_at(text + i - start) != words[i]:  # a shorter text ends in 0 and differs there
            return False
    return character_at(text + end - start) == 0


@inner
def add_choices(sentence, n, words):
    """Appends words, which blanks separate in `words`, as "a, b or c"; returns the new n."""
    last = len(words) - 1
    while last >= 0 and words[last] != ord(" "):
        last -= 1
    for i in range(len(words)):
        if words[i] != ord(" "):
            if n < SENTENCE_LIMIT - 1:
                sentence[n] = words[i]
                n += 1
        elif i == last:
            n = add(sentence, n, b" or ")
        else:
            n = add(sentence, n, b", ")
    return n
