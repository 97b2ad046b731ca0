# SPDX-License-Identifier: Apache-2.0
"""Whether certificate and key of a member are whole and belong together: damage shows before any link."""

from __future__ import annotations

from cryptography import x509
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives import serialization

from robotskin.fleet.errors import FleetError


def require_sound(authority: str, certificate: str, key: str, common_name: str, what: str) -> None:
    """Texts in PEM. Raises FleetError, naming `what`: damaged, not of one another, or of another member."""
    try:
        signer = x509.load_pem_x509_certificate(authority.encode())
        own = x509.load_pem_x509_certificate(certificate.encode())
        private = serialization.load_pem_private_key(key.encode(), None)
        if private.public_key() != own.public_key():
            raise ValueError("key and certificate do not belong together")
        signer.verify_directly_issued_by(signer)
        own.verify_directly_issued_by(signer)
        names = [one.value for one in own.subject]
        if names != [common_name]:
            raise ValueError(f"the certificate is of {names}, not of {common_name!r}")
    except (ValueError, TypeError, InvalidSignature) as error:
        reason = "the authority has not signed the certificate" if isinstance(error, InvalidSignature) else error
        raise FleetError(f"{what}: damaged: {reason}; make it anew with 'robotskin fleet keys --replace'") from None
