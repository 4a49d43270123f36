"""What a user can choose: declared options, and the checks of a given number or name.

Contents:
    Parameter, Group, Written: A declared option; a name with its options.
    parameters_of, parameters_of_fields, check_declared: The options of a function or a dataclass.
    parameters_of_class, initial_values: What any class lets its user set.
    split_options, split_headed, with_options, without_class_options: Options within a name.
    find_parameter, parse_options: Values for options.
    argument_notes: What a docstring says about each argument.

Limits of numbers are in ``bounds``, and misspelt names in ``known_names``.
"""

from worldgen.parameters.declared import (
    Group,
    Parameter,
    Written,
    argument_notes,
    check_declared,
    find_parameter,
    initial_values,
    parameters_of,
    parameters_of_class,
    parameters_of_fields,
    parse_options,
    split_headed,
    split_options,
    with_options,
    without_class_options,
)

__all__ = [
    "Group",
    "Parameter",
    "Written",
    "argument_notes",
    "check_declared",
    "find_parameter",
    "initial_values",
    "parameters_of",
    "parameters_of_class",
    "parameters_of_fields",
    "parse_options",
    "split_headed",
    "split_options",
    "with_options",
    "without_class_options",
]
