"""The windows of the menu: options of the in-betweens, and tables."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pxr.Usdviewq.qt import QtWidgets

from geomstats_anim.names import SCHEME_NAMES


def ask_options(api: Any) -> dict[str, Any] | None:
    """Ask for factor, scheme and styles; None if the user thinks better of it."""
    dialog = QtWidgets.QDialog(api.qMainWindow)
    dialog.setWindowTitle("Geodesic In-betweens")
    form = QtWidgets.QFormLayout(dialog)
    factor = QtWidgets.QSpinBox()
    factor.setRange(2, 1000)
    factor.setValue(4)
    form.addRow("Parts of each gap", factor)
    scheme = QtWidgets.QComboBox()
    scheme.addItems(["as stored", *SCHEME_NAMES])
    form.addRow("Scheme", scheme)
    styles = QtWidgets.QLineEdit()
    styles.setPlaceholderText("*Arm*:alpha=4,tension=.5  Head:invariance=right")
    styles.setMinimumWidth(320)
    form.addRow("Styles, with spaces between", styles)
    kinds = QtWidgets.QDialogButtonBox
    buttons = kinds(kinds.StandardButton.Ok | kinds.StandardButton.Cancel)
    buttons.accepted.connect(dialog.accept)
    buttons.rejected.connect(dialog.reject)
    form.addRow(buttons)
    if dialog.exec_() != QtWidgets.QDialog.DialogCode.Accepted:
        return None
    chosen = scheme.currentText() if scheme.currentIndex() else None
    return {"factor": factor.value(), "scheme": chosen, "joint": tuple(styles.text().split())}


def show_tables(api: Any, tables: Sequence[tuple[str, Sequence[str], Sequence[Sequence[str]]]]) -> None:
    """Show tables, each with its title above."""
    dialog = QtWidgets.QDialog(api.qMainWindow)
    dialog.setWindowTitle("Metric of Each Joint")
    layout = QtWidgets.QVBoxLayout(dialog)
    for title, header, rows in tables:
        layout.addWidget(QtWidgets.QLabel(title))
        table = QtWidgets.QTableWidget(len(rows), len(header))
        table.setHorizontalHeaderLabels(list(header))
        table.setEditTriggers(QtWidgets.QAbstractItemView.EditTrigger.NoEditTriggers)
        for i, row in enumerate(rows):
            for j, text in enumerate(row):
                table.setItem(i, j, QtWidgets.QTableWidgetItem(text))
        table.resizeColumnsToContents()
        layout.addWidget(table)
    dialog.resize(640, 480)
    dialog.exec_()
