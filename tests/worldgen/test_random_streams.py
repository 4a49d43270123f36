"""Random numbers: the published vectors, and the promises of each way of drawing."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from worldgen.random_streams import RandomStream

SEEDS = st.integers(0, 2**64 - 1)


def test_outputs_are_those_published_for_splitmix64():
    stream = RandomStream(1234567)
    assert [stream.next64() for _ in range(5)] == [
        6457827717110365317,
        3203168211198807973,
        9817491932198370423,
        4593380528125082431,
        16408922859458223821,
    ]


@given(SEEDS, st.lists(st.integers(0, 40), max_size=4))
def test_bits_are_next64_repeated(seed, counts):
    blocks, single = RandomStream(seed), RandomStream(seed)
    for count in counts:
        assert blocks.bits(count).tolist() == [single.next64() for _ in range(count)]
    assert blocks.next64() == single.next64()


@given(SEEDS, st.integers(0, 40))
def test_floats_are_random_repeated(seed, count):
    blocks, single = RandomStream(seed), RandomStream(seed)
    assert blocks.floats(count).tolist() == [single.random() for _ in range(count)]


@given(SEEDS)
def test_floats_lie_in_the_half_open_unit_interval(seed):
    values = RandomStream(seed).floats(100)
    assert ((values >= 0.0) & (values < 1.0)).all()


@given(SEEDS, st.integers(1, 2**64))
def test_below_stays_below(seed, bound):
    assert 0 <= RandomStream(seed).below(bound) < bound


def test_below_redraws_what_would_favour_small_numbers():
    bound = 3 * 2**62  # a plain multiply-and-shift would give a third of the numbers twice as often
    stream = RandomStream(5)
    thirds = Counter(stream.below(bound) // 2**62 for _ in range(6000))
    remainders = Counter(stream.below(bound) % 3 for _ in range(6000))
    for share in (*thirds.values(), *remainders.values()):
        assert abs(share - 2000) < 4 * np.sqrt(6000 * 2 / 9)


@pytest.mark.parametrize("bound", [2, 3, 7, 10, 192])
def test_below_is_even(bound):
    stream, draws = RandomStream(11), 100 * bound
    counts = np.bincount([stream.below(bound) for _ in range(draws)], minlength=bound)
    assert ((counts - 100.0) ** 2 / 100.0).sum() < bound + 5 * np.sqrt(
        2 * bound
    )  # chi-square, mean + 5 sigma


@given(SEEDS, st.integers(-50, 50), st.integers(0, 20))
def test_between_includes_both_ends(seed, low, width):
    stream = RandomStream(seed)
    drawn = {stream.between(low, low + width) for _ in range(40 * (width + 1))}
    assert drawn == set(range(low, low + width + 1))


def test_below_nothing_is_refused():
    with pytest.raises(ValueError, match="bound=0: must be at least 1"):
        RandomStream(0).below(0)


def test_every_order_of_a_shuffle_is_as_likely():
    stream, counts = RandomStream(3), Counter()
    for _ in range(2400):
        items = [0, 1, 2, 3]
        stream.shuffle(items)
        counts[tuple(items)] += 1
    assert len(counts) == 24
    assert (
        sum((count - 100) ** 2 / 100 for count in counts.values()) < 50
    )  # chi-square, 23 degrees: p < 0.001


@given(SEEDS)
def test_a_child_does_not_move_its_parent(seed):
    parent, untouched = RandomStream(seed), RandomStream(seed)
    parent.child("walls", 3).bits(10)
    assert parent.next64() == untouched.next64()


def test_children_of_different_labels_differ():
    parent = RandomStream(9)
    labels = [(), ("a",), ("b",), (0,), (1,), ("a", 0), ("a", 1), (0, "a"), ("ab",), ("a", "b")]
    assert len({parent.child(*label).next64() for label in labels}) == len(labels)


def test_a_child_draws_what_it_always_drew():
    assert RandomStream(7).child("maze", 0).next64() == 7859114659821238380


def test_only_the_low_64_bits_of_a_seed_count():
    assert RandomStream(2**64 + 5).next64() == RandomStream(5).next64()
